"""Laws control what their loop does, or are refused."""

import math

import pytest

from hydroservo import Aim, ParameterError, ScenarioError, load_scenario, plot, replace, simulate, tune
from hydroservo.control.controlled import Command, Force, LoadPressure, Position, PressureA, Velocity
from hydroservo.control.controllers import DAC, PI, TSMC, Backstepping, OpenLoop
from hydroservo.control.references import Sine, Step
from hydroservo.core.block import Block, field_at
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.loads import Constant
from hydroservo.runs.run import runnable_loop
from hydroservo.testing.examples import example
from tests.support.monitors import SHORT


@pytest.mark.parametrize("controls", [Velocity(), Position(), Force(), PressureA()])
@pytest.mark.parametrize("wrapped", [False, True])
def test_a_law_is_told_what_its_loop_controls(controls: Block, wrapped: bool) -> None:
    law = example(DAC, PI(5.0)) if wrapped else PI(5.0)
    loop = runnable_loop(SHORT._replace(controls=controls, controller=law))
    path = "controller.controller" if wrapped else "controller"
    inner = loop.controller.controller if wrapped else loop.controller
    assert type(inner.controls) is type(controls)
    unit = {"m/s": "V s/m"}.get(controls.declared().unit, f"V/{controls.declared().unit}")
    assert field_at(loop, f"{path}.proportional_gain").unit == unit


def test_a_law_in_no_loop_is_not_given_the_velocity_for_its_signal() -> None:
    law, y = PI(5.0), Measurement(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
    assert math.isnan(law.step(law.init(), y, Demand(1.0, 0.0, 0.0), 1e-3).u)
    law = PI(5.0, controls=Position())
    assert law.step(law.init(), y, Demand(1.0, 0.0, 0.0), 1e-3).u == pytest.approx(5.0 * 0.7)


@pytest.mark.parametrize(
    ("law", "controls", "problem"),
    [
        (TSMC, Position(), "controller = 'TSMC': controls the velocity, and here the position is controlled"),
        (Backstepping, Command(), "controls the velocity, and here the command is controlled"),
        (OpenLoop, Velocity(), "controls the command, and here the velocity is controlled"),
        (PI, Command(), "closes a loop, and an open one has none: its law is OpenLoop"),
    ],
)
def test_a_law_for_another_signal_is_refused(law: type, controls: Block, problem: str) -> None:
    for controller in (example(law), example(DAC, example(law))):
        with pytest.raises(ParameterError) as caught:
            simulate(SHORT._replace(controls=controls, controller=controller))
        assert problem.partition("controls the")[2] in str(caught.value)


def test_a_law_that_was_told_another_signal_is_refused() -> None:
    told = PI(5.0, controls=Velocity())
    with pytest.raises(ParameterError, match="controls the velocity, and here the position is controlled"):
        simulate(SHORT._replace(controls=Position(), controller=told))
    with pytest.raises(ScenarioError, match="controls the velocity"):
        load_scenario("paper/sine-tsmc", {"controls.type": "Position", "reference.amplitude": "1 mm"})


def test_the_demand_of_an_open_loop_is_its_command() -> None:
    loop = SHORT._replace(controls=Command(), controller=OpenLoop(), reference=Sine(2.0, 5.0))
    data = simulate(loop)
    assert data["controller.u"].values == pytest.approx(data["reference.value"].values)
    assert data["controlled.value"].attrs["units"] == "V"
    assert "rms_error" not in data  # there is none
    limited = simulate(replace(loop, {"controller.saturation.limit": 1.0}))
    assert float(limited["control_max"]) == 1.0


def test_a_position_loop_goes_where_it_is_asked_to() -> None:
    reference = Step(0.039, 0.044)
    law, rest = PI(10.0), Constant(0.0)
    loop = SHORT._replace(controls=Position(), reference=reference, load=rest, controller=law)
    loop = replace(loop, {"simulation.duration": 1.0})
    data = simulate(loop)
    assert data["controlled.value"].values == pytest.approx(data["plant.position"].values)
    assert data["rms_error"].attrs == {
        "units": "m",
        "long_name": "rms of the position error",
        "kind": "metric",
        "better": "smaller",
    }
    assert float(data["plant.position"][-1]) == pytest.approx(0.044, abs=1e-4)
    assert 0.1 < float(data["settling_time"]) < 0.5


def test_runs_of_different_signals_are_not_laid_side_by_side() -> None:
    position = SHORT._replace(controls=Position(), reference=Step(0.039, 0.044, 0.0), controller=PI(10.0))
    with pytest.raises(ParameterError, match="loops = 'velocity, position': must all be of one"):
        tune(Aim([SHORT, position]), {"controller.proportional_gain": (1.0, 10.0)}, candidates=2)
    brief = {"simulation.duration": 0.01}
    runs = [simulate(replace(one, brief), compiled=False) for one in (SHORT, position)]
    with pytest.raises(ParameterError, match="must all be of one controlled signal"):
        plot(runs)


@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")
@pytest.mark.parametrize(
    ("controls", "asked", "said"),
    [
        (Position(), 0.1, "the demand goes to 100 mm; the machine's position is from 0 mm to 78.0 mm"),
        (Force(), -1e5, "the demand goes to -100 kN; the machine's force is from -1960 N to 1960 N"),
        (
            PressureA(),
            5e6,
            "the machine's pressure A is from -1.01 bar to 40.0 bar",
        ),
        (LoadPressure(), 5e6, "the machine's load pressure is from -40.0 bar to 40.0 bar"),
        (Position(), 0.07, ""),
    ],
)
def test_a_demand_that_the_machine_cannot_meet_is_said(controls: Block, asked: float, said: str) -> None:
    loop = SHORT._replace(controls=controls, reference=Step(0.0, asked, 5e-3), controller=PI(1e-9))
    data = simulate(replace(loop, {"simulation.duration": 0.01}), compiled=False)
    assert said in data.attrs.get("warning", "")
    assert ("the demand goes to" in data.attrs.get("warning", "")) == bool(said)
