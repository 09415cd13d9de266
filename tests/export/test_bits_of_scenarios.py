"""Exported loops of built-in scenarios give the bits of strict Python over whole runs."""

from pathlib import Path

import numpy as np
import pytest

from hydroservo import simulate
from hydroservo.core.block import leaves
from hydroservo.export.parts import Command, ControllerUnit, ExternalForce, MachineUnit
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import load_scenario
from tests.support.digests import digest, stored
from tests.support.export.agreement import assert_same_run, run_in_c
from tests.support.scenarios import LOOPS
from tests.support.tiers import mostly


@pytest.mark.slow
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LOOPS, ["axis/position", "paper/sine-tsmc"]))
def test_built_in_scenarios(name: str, tmp_path: Path) -> None:
    # tests/regression holds the strict simulation against the same digests.
    found = {path: digest(values) for path, values in run_in_c(load_scenario(name), tmp_path).items()}
    wanted = stored()[name]
    assert {path: one for path, one in found.items() if wanted[path] != one} == {}
    assert set(found) == {path for path in wanted if "." in path and not path.startswith("disturbance.")}


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["Tsit5", "Rosenbrock"])
def test_other_integrators(integrator: str, tmp_path: Path) -> None:
    changes = {"simulation.integrator.type": integrator, "simulation.duration": "0.5 s"}
    assert_same_run(load_scenario("rig/excavator-link", changes), tmp_path, compiled=True)


@pytest.mark.parametrize("shape", ["CurvedEdges", "FourCurves"])
def test_a_spool_with_notches_that_feeds_the_rod_side_back(shape: str, tmp_path: Path) -> None:
    points = [["0 %", "0 %"], ["20 %", "0 %"], ["50 %", "10 %"], ["100 %", "100 %"]]
    names = ("curve",) if shape == "CurvedEdges" else ("pa", "at", "pb", "bt")
    table = {"type": shape, "full_opening": "1 mm"} | {name: {"points": points} for name in names}
    changes = {"shape": table, "regeneration": True}
    loop = load_scenario(
        "rig/excavator-link",
        {"simulation.duration": "0.2 s"} | {f"valve.orifice.{key}": value for key, value in changes.items()},
    )
    assert_same_run(loop, tmp_path, compiled=True)


def test_controller_and_machine_in_turn_are_the_loop() -> None:
    changes = {"simulation.duration": "0.2 s", "simulation.record_period": "1 ms"}
    loop = runnable_loop(load_scenario("rig/encoder-tsmc-sine", changes))
    period = loop.simulation.period
    controller, machine = ControllerUnit(loop.controller, period), MachineUnit(loop, period)
    state, s = controller.init(), machine.init()
    data = simulate(loop, compiled=False)
    for k in range(data.sizes["time"]):
        state = controller.step(state, s.measurement, loop.reference.at(k * period))
        for path, number in leaves(state):
            assert data[f"controller.{path}"].values[k] == number, path
        for part in ("plant", "valve", "sensors"):
            for path, number in leaves(getattr(s, part)):
                assert np.array_equal(data[f"{part}.{path}"].values[k], number, equal_nan=True), path
        s = machine.step(s, Command(state.u), ExternalForce(0.0))
