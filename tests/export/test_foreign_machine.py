"""An exported machine as the machine of a loop: the bits of the run that it came from."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hydroservo import simulate
from hydroservo.control.loop import Loop
from hydroservo.core.errors import LoopError, ParameterError, ScenarioError
from hydroservo.export.fmu import FmiVersion, write_fmu
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.scenario import load_scenario
from hydroservo.scenario.load import assemble
from tests.support.export.foreign import folder

pytestmark = pytest.mark.slow  # each builds a library or a program

PI, TSMC = "rig/1khz-pi-sine", "rig/1khz-tsmc-sine"
SHORT = {"simulation.duration": "0.2 s"}


@cache
def machine(name: str, version: FmiVersion) -> Path:
    unit = exported_unit(load_scenario(name, SHORT), Part.MACHINE, prefix="unit", title=name)
    place = Path(folder(f"{name} {version}").name)
    return write_fmu(unit, place / "machine.fmu", stop_time=1.0, version=version)


def around(name: str, version: FmiVersion, **more: Any) -> Loop:
    """A scenario's law around its exported machine, in which its load is."""
    file = machine(name, version)
    inside = {"plant": {"type": "FMU", "file": str(file)}, "load": {"type": "Constant", "amplitude": 0.0}}
    return load_scenario(name, SHORT | inside | more, plugins=[file])


@pytest.mark.parametrize("version", FmiVersion)
def test_a_law_around_its_exported_machine_gives_the_bits_of_its_run(version: FmiVersion) -> None:
    own = simulate(load_scenario(PI, SHORT), strict=True)
    found = simulate(around(PI, version))
    names = [
        "plant.velocity",
        "plant.position",
        "plant.hydraulic_force",
        "controller.u",
        "controller.integral",
    ]
    for name in names:
        np.testing.assert_array_equal(found[name], own[name], err_msg=name)
    for name in ("control_rms", "control_total_variation"):
        assert found[name] == own[name]
    assert float(abs(own["plant.velocity"]).max()) > 1e-3


def test_a_law_with_a_model_believes_in_the_nominal_plant() -> None:
    nominal = assemble(TSMC, SHORT).nominal.plant
    numbers = {f"plant.nominal.{name}": value for name, value in nominal._asdict().items()}
    believed = {"plant.nominal.type": type(nominal).__name__} | numbers
    own, found = simulate(load_scenario(TSMC, SHORT), strict=True), simulate(around_tsmc(believed))
    for name in ("plant.velocity", "controller.u", "controller.controller.observer.d1"):
        np.testing.assert_array_equal(found[name], own[name], err_msg=name)


def around_tsmc(believed: dict[str, Any]) -> Loop:
    file = machine(TSMC, FmiVersion.FMI3)
    inside = {"plant.type": "FMU", "plant.file": str(file), "load.type": "Constant", "load.amplitude": 0.0}
    return load_scenario(TSMC, SHORT | inside | believed, plugins=[file])


def test_a_law_that_needs_a_model_asks_for_one() -> None:
    with pytest.raises(ScenarioError, match=r"plant\.nominal = 'NoNominal': must be a cylinder"):
        around_tsmc({})


def test_parameters_of_the_fmu_are_set() -> None:
    file = machine(PI, FmiVersion.FMI2)
    table = {"type": "FMU", "file": str(file), "parameters": {"plant": {"mass": "7000 g"}}}
    heavy = around(PI, FmiVersion.FMI2, plant=table)
    own = simulate(load_scenario(PI, SHORT | {"plant.mass": 7.0}), strict=True, record=["plant.velocity"])
    found = simulate(heavy, record=["plant.velocity"])
    np.testing.assert_array_equal(found["plant.velocity"], own["plant.velocity"])


@pytest.mark.parametrize(
    ("more", "error", "said"),
    [
        ({"plant.step": "0.5 ms"}, LoopError, "0.0005 s is not a whole multiple of the sample period"),
        ({"plant.step": "0.3 ms"}, ParameterError, "plant.step = 0.0003: must divide the sample period"),
        ({"load.amplitude": 5.0}, LoopError, "takes no force of the load Constant"),
        ({"hold": {"type": "DelayedHold", "delay": 2e-4}}, ParameterError, "must be whole communication"),
        ({"start.given.plant.position": 0.1}, ParameterError, "starts where itself says"),
        (
            {"plant.signals.hydraulic_force": "plant.velocity"},
            ScenarioError,
            "in m/s and does not convert",
        ),
        ({"plant.parameters.plant.mass": "7 mm"}, ScenarioError, "does not convert to kg"),
        ({"plant.parameters.plant.mas": 7}, ScenarioError, "did you mean plant.mass"),
        ({"plant.signals.command": "u"}, ScenarioError, "'u' is not a variable of the FMU"),
    ],
)
def test_what_does_not_go_together_is_said_in_a_line(
    more: dict[str, Any], error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said) as caught:
        run_with(more)
    assert "\n" not in str(caught.value)


def run_with(more: dict[str, Any]) -> None:
    file = machine(PI, FmiVersion.FMI2)
    inside = {"plant.type": "FMU", "plant.file": str(file), "load.type": "Constant", "load.amplitude": 0.0}
    simulate(load_scenario(PI, SHORT | inside | more, plugins=[file]))


def test_a_signal_that_the_fmu_does_not_answer_is_missed_by_the_law_that_needs_it() -> None:
    loop = around(PI, FmiVersion.FMI2)
    foreign = loop.plant.foreign  # type: ignore[attr-defined]
    position = tuple(wire for wire in foreign.outputs if wire.signal == "position")
    cls = type("FMU", (type(loop.plant),), {"foreign": foreign._replace(outputs=position)})
    with pytest.raises(LoopError, match=r"PI needs velocity .* does not answer; name its variable in"):
        simulate(loop._replace(plant=cls(*loop.plant)))  # type: ignore[misc]
