"""FMUs as the load of a loop: one with arrays, and those of another tool in FMI 2.0 and 3.0."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from hydroservo import simulate, simulate_batch
from hydroservo.control.loop import Loop
from hydroservo.core.errors import LoopError
from hydroservo.cosimulation.instance import Instance
from hydroservo.linear.moving_margins import is_unstable
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario import load_scenario
from tests.support.export.foreign import DAMPING, SPRING, STIFFNESS, by_python_fmu, foreign_load, with_changes

pytestmark = pytest.mark.slow  # each builds a library or a program

EXAMPLES = Path(__file__).parents[2] / "examples"
VELOCITY = "plant.velocity"


def own_spring() -> Loop:
    """The same spring and damper as a mechanism of hydroservo."""
    spring = {"stiffness": STIFFNESS, "damping": DAMPING, "rest_position": 0.0}
    mechanism = {"type": "MassSpringDamper", **spring}
    return with_changes({"type": "Constant", "amplitude": 0.0}, **{"plant.mechanism": mechanism})


def test_a_spring_in_an_fmu_is_one_of_ours_to_the_first_order_of_the_step() -> None:
    own = simulate(own_spring(), record=[VELOCITY])[VELOCITY]
    errors = []
    for parts in (1, 2, 4):
        loop = foreign_load({**SPRING, "step": 1e-3 / parts})
        errors.append(float(abs(simulate(loop, record=[VELOCITY])[VELOCITY] - own).max()))
    assert errors[0] < 1e-3 * float(abs(own).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(1.0, abs=0.05)


def test_an_fmu_is_given_the_motion_at_each_sample_and_answers_there() -> None:
    """A lag in the FMU, which takes Euler's steps of 1 ms: its recursion over the recorded motion."""
    a, b, c, d = -40.0, (300.0, 9000.0), 3.0, (0.0, 50.0)
    matrices = {"m": 2, "n": 1, "r": 2, "A": a, "B": list(b), "C": [c, 0.0], "D": [*d, 0.0, 0.0]}
    data = simulate(foreign_load({**SPRING, "parameters": matrices}))
    x, expected = 0.0, []
    for u in zip(data["plant.position"].values, data[VELOCITY].values, strict=True):
        expected.append(c * x + (d[0] * u[0] + d[1] * u[1]))
        x += 1e-3 * (a * x + (b[0] * u[0] + b[1] * u[1]))
    np.testing.assert_allclose(data["load.force"].values, expected, rtol=1e-13)
    assert abs(data["load.force"]).max() > 10.0


def test_the_fmu_of_another_tool_gives_the_same_run() -> None:
    file = by_python_fmu("pythonfmu3", EXAMPLES / "spring_fmu.py", "Spring")
    table = {"type": "FMU", "file": str(file), "parameters": {"stiffness": STIFFNESS, "damping": DAMPING}}
    data, ours = simulate(with_changes(table, plugins=[file])), simulate(foreign_load())
    for name in ("load.force", VELOCITY):
        np.testing.assert_array_equal(data[name], ours[name])


def test_of_a_loop_with_an_fmu_nothing_is_said_of_its_stability() -> None:
    assert not is_unstable(foreign_load())


THROUGH = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Through(Fmi2Slave):
    def __init__(self, **options):
        super().__init__(**options)
        self.u = self.y = 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output, getter=lambda: self.u))

    def do_step(self, current_time, step_size):
        return True
"""


def test_units_are_converted(tmp_path: Path) -> None:
    """An FMU of FMI 2.0 that returns what it is given: 1 kN for each mm/s."""
    (tmp_path / "through.py").write_text(THROUGH)
    file = by_python_fmu("pythonfmu", tmp_path / "through.py", "Through")
    load = {"type": "FMU", "file": str(file), "signals": {"velocity": "u [mm/s]", "force": "y [kN]"}}
    changes = {"simulation.duration": "50 ms", "load": load}
    data = simulate(load_scenario("rig/1khz-pi-sine", changes, plugins=[file]))
    np.testing.assert_allclose(data["load.force"], 1e6 * data[VELOCITY], rtol=1e-14)
    assert abs(data["load.force"]).max() > 1.0


def test_the_rod_rests_against_the_force_at_the_start() -> None:
    data = simulate(foreign_load(), record=["load.force", VELOCITY])
    assert float(data["load.force"][0]) == pytest.approx(STIFFNESS * 0.05, rel=1e-3)
    assert abs(float(data[VELOCITY][1])) < 1e-3


def metrics_of(data: xr.Dataset) -> dict[str, Any]:
    return {str(name): value.item() for name, value in data.data_vars.items() if not value.dims}


def test_runs_do_not_know_of_each_other() -> None:
    loop = foreign_load()
    first = simulate(loop)
    with ThreadPoolExecutor(3) as pool:
        assert all(data.equals(first) for data in pool.map(simulate, [loop] * 3))
    table = simulate_batch(loop, {"plant.friction.viscous": np.array([1000.0, 1500.0])})
    changed = foreign_load(**{"plant.friction.viscous": 1500.0})
    for i, alone in enumerate((first, simulate(changed))):
        row = {name: table[name].values[i].item() for name in metrics_of(alone)}
        np.testing.assert_equal(row, metrics_of(alone))
    assert table["position_max"][0] != table["position_max"][1]


def test_a_loop_can_be_pickled_and_its_hash_tells_its_fmu() -> None:
    loop = foreign_load()
    again = pickle.loads(pickle.dumps(loop))
    assert again == loop
    assert type(again.load) is type(loop.load)
    other = foreign_load({**SPRING, "parameters": {**SPRING["parameters"], "D": [STIFFNESS, 0.0]}})
    assert len({scenario_hash(one) for one in (loop, again, other)}) == 2


def test_a_force_that_is_no_number_has_diverged() -> None:
    matrices = {"m": 2, "n": 1, "r": 1, "A": 1e300, "B": [1.0, 1.0], "C": 0.0, "D": [0.0, 0.0]}
    data = simulate(foreign_load({**SPRING, "parameters": matrices}))
    assert data.attrs["diverged_by"] == "load.force"
    assert 0.0 < float(data["diverged_at"]) < 0.01


def test_an_fmu_that_can_have_one_instance_has_one() -> None:
    foreign = foreign_load().load.foreign  # type: ignore[attr-defined]
    alone = foreign._replace(fmu=foreign.fmu._replace(single=True))
    start = {"position": 0.0, "velocity": 0.0}
    for _ in range(2):
        with Instance(alone, "load", start), pytest.raises(LoopError, match="has one already"):
            Instance(alone, "load", start)
