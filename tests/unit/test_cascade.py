"""Position over velocity: what the nested law is given, in which units, and what it comes to."""

from pathlib import Path
from typing import Annotated, NamedTuple

import pytest

from hydroservo import Field, Loop, ParameterError, ScenarioError, Simulation, replace, simulate
from hydroservo.control.controlled import Force, Position, Velocity
from hydroservo.control.controlled.this_signal import ThisSignal
from hydroservo.control.controllers import DAC, PI, PID, TSMC, AntiWindup, Cascade, Inverting, Saturation
from hydroservo.control.error_dynamics import TerminalErrorDynamics
from hydroservo.control.outline import outline
from hydroservo.control.wiring import wired
from hydroservo.core.block import Block, field_at, value_at
from hydroservo.core.group import nested
from hydroservo.core.signals import Demand, Measurement
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.machine.starts import AsBuilt
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import on_base
from tests.support.equality import assert_same_block

H = 1e-3
BRIEF = Simulation(5e-3, 1e-3, 20, record_period=1e-3)
SCENARIO = """
[controls]
type = "Position"

[reference]
type = "Step"
initial = "39 mm"
final = "40 mm"
time = "1 ms"

[controller]
type = "Cascade"
proportional_gain = "20 1/s"
max_velocity = "50 mm/s"
controller.type = "PI"
controller.proportional_gain = "3 V s/m"
"""


class GivenState(NamedTuple):
    u: Annotated[float, Field("V", "command")]
    value: Annotated[float, Field("m/s", "demand")]
    rate: Annotated[float, Field("m/s^2", "its rate")]
    second_rate: Annotated[float, Field("m/s^3", "its second rate")]


class Given(NamedTuple):
    """A law that keeps what it is given."""

    def init(self) -> GivenState:
        return GivenState(0.0, 0.0, 0.0, 0.0)

    def step(self, s: GivenState, y: Measurement, r: Demand, dt: float) -> GivenState:
        return GivenState(0.0, r.value, r.rate, r.second_rate)


def at(position: float, velocity: float = 0.0) -> Measurement:
    return Measurement(velocity, 0.0, position, 0.0, 0.0, 0.0, 700.0)


def test_the_nested_law_is_given_a_velocity_with_the_rates_of_the_feedforward() -> None:
    law = Cascade(Given(), 10.0, max_velocity=1.0, rate_feedforward=0.5, controls=Position())
    s = law.step(law.init(), at(0.02), Demand(0.03, 0.4, 6.0), H)
    assert tuple(s.controller)[1:] == pytest.approx((0.1 + 0.2, 3.0, 0.0))
    assert s.velocity_demand == s.controller.value


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_limited_velocity_is_constant(sign: float) -> None:
    law = Cascade(Given(), 10.0, max_velocity=0.25, rate_feedforward=0.5, controls=Position())
    s = law.step(law.init(), at(0.0), Demand(sign * 0.03, 0.0, 6.0), H)
    assert tuple(s.controller)[1:] == (sign * 0.25, 0.0, 0.0)


def test_over_a_feedforward_alone_it_is_a_p_law() -> None:
    """u = k_0 k_p e."""
    cascade = Cascade(PID(0.0, feedforward=8.0, controls=Velocity()), 10.0, 1e3, controls=Position())
    law = PI(80.0, controls=Position())
    for position in (-0.05, 0.0, 0.02, 0.3):
        y, r = at(position, velocity=0.7), Demand(0.01, 0.0, 0.0)
        assert cascade.step(cascade.init(), y, r, H).u == pytest.approx(law.step(law.init(), y, r, H).u)


def test_over_a_p_law_it_is_a_p_law_with_velocity_feedback() -> None:
    """u = k_v (k_p e - v)."""
    cascade = Cascade(
        PI(8.0, saturation=Saturation(99.0), controls=Velocity()), 10.0, 1e3, controls=Position()
    )
    u = cascade.step(cascade.init(), at(0.02, velocity=0.7), Demand(0.1, 0.0, 0.0), H).u
    assert u == pytest.approx(8.0 * (10.0 * 0.08 - 0.7))


def test_the_nested_law_controls_the_velocity_whatever_the_loop_controls() -> None:
    loop = example(Loop, controller=example(Cascade), controls=Position())
    law = runnable_loop(loop).controller
    assert (type(law.controls), type(law.controller.controls)) == (Position, Velocity)
    assert type(wired(loop).controller.controls) is ThisSignal  # so that the loop may yet control another
    law = runnable_loop(replace(wired(loop), {"controls": Force()})).controller
    assert (type(law.controls), type(law.controller.controls)) == (Force, Velocity)


def test_a_law_for_velocities_alone_holds_a_position_inside() -> None:
    """The first paper's law, which a position loop refuses by itself."""
    loop = example(Loop, controller=example(TSMC), controls=Position())
    with pytest.raises(ParameterError, match="controls the velocity, and here the position is controlled"):
        wired(loop)
    law = runnable_loop(loop._replace(controller=example(Cascade, example(TSMC)))).controller
    assert type(law.controls) is Position


@pytest.mark.slow  # each compiles a loop
@pytest.mark.parametrize("name", ["OffsetFreeLQ", "Inverting"])
def test_any_law_of_the_velocity_serves_a_position(name: str) -> None:
    """On a single-rod axis with overlap: 200 mm, and then 3 kN."""
    loop = load_scenario("axis/position-lq")
    path = "controller.controller.controller.controller"
    if name == "Inverting":
        loop = replace(loop, {"controller.controller.threshold": 0.71235})
        found = {"disturbance_1": 0.058702, "disturbance_2": 3280.1, "hydraulic_force_noise": 552.5}
        observer = replace(value_at(loop, f"{path}.observer"), found)
        law = Inverting(TerminalErrorDynamics(400.0, 400.0, 0.01, 0.1, 5 / 7, 5 / 9), observer)
        loop = replace(loop, {path: law, "controller.controller.controller.proportional_gain": 80.0})
    run = simulate(loop)
    assert not run.diverged
    assert type(value_at(loop, path)).__name__ == name
    assert float(run.max_error) < 5e-4
    assert abs(float(run["plant.position"][-1]) - 0.25) < 2e-4


@pytest.mark.parametrize(("controls", "units"), [(Position(), ("1/s", "")), (Force(), ("m/(s N)", "m/N"))])
def test_units_are_those_of_each_loop(controls: Position | Force, units: tuple[str, str]) -> None:
    loop = wired(example(Loop, controller=example(Cascade), controls=controls))
    names = ("proportional_gain", "rate_feedforward", "controller.proportional_gain")
    assert [field_at(loop, f"controller.{name}").unit for name in names] == [*units, "V s/m"]
    assert f"proportional_gain 10 {units[0]}" in outline(loop)


def test_a_number_has_one_unit_wherever_it_is_said() -> None:
    """In a wrapper around and in one inside, in what is recorded, in C, and as a state that is given."""
    inner = AntiWindup(PI(3.0, saturation=Saturation(1e4)), 3.0, Saturation(1e3))
    law = AntiWindup(Cascade(inner, 10.0, 1.0), 5.0, Saturation(5.0))
    loop = example(Loop, BRIEF, controller=law, controls=Position())
    wanted = {
        "controller.gain": "V/m",
        "controller.controller.proportional_gain": "1/s",
        "controller.controller.controller.gain": "V s/m",
        "controller.controller.controller.controller.proportional_gain": "V s/m",
    }
    assert {path: field_at(loop, path).unit for path in wanted} == wanted
    states = {
        "controller.r.value": ("m", "position demand"),
        "controller.controller.controller.r.value": ("m/s", "velocity demand"),
        "controller.controller.controller.r.rate": ("m/s^2", "first derivative of the velocity demand"),
        "controller.before.controller.r.value": ("m/s", "velocity demand"),  # a copy of the nested law's
        "controlled.value": ("m", "position"),
    }
    run = simulate(loop, record=list(states), metrics=(), compiled=False)
    assert {path: (run[path].units, run[path].long_name) for path in states} == states
    said = {  # of a struct that is at places of both
        Part.CONTROLLER: "double value; /* [m or m/s] position or velocity demand */",
        Part.LOOP: "double value; /* [m/s or m] velocity or position demand */",
    }
    for part, struct in said.items():
        unit = exported_unit(loop, part, prefix="law", title="a cascade")
        found = {one.path: one.unit for one in unit.parameters}
        assert {path: found[path] for path in wanted} == wanted
        found = {one.path: (one.unit, one.meaning) for one in unit.states}
        assert {path: found[path] for path in states if path in found} == {
            path: pair for path, pair in states.items() if part is Part.LOOP or path.startswith("controller")
        }
        header = " ".join(unit.header.split())
        for gain in wanted.values():
            assert f"[{gain}]" in header
        assert struct in header
    given = {path: 0.0 for path in states if path.startswith("controller.")}
    started = loop._replace(start=AsBuilt(nested(given)))
    units = {path: field_at(started, f"start.given.{path}").unit for path in given}
    assert units == {path: unit for path, (unit, _) in states.items() if path in given}


def test_a_law_of_one_s_own_may_have_another_signal_inside() -> None:
    """Of a force inside, whatever the loop controls, and around a law that wraps another."""

    class OverForce(NamedTuple):
        controller: Block
        inner_controls: Force = Force()

        def init(self) -> Block:
            return self.controller.init()

        def step(self, s: Block, y: Measurement, r: Demand, dt: float) -> Block:
            return self.controller.step(s, y, Demand(0.0, 0.0, 0.0), dt)

    loop = example(Loop, BRIEF, controller=OverForce(DAC(PI(1e-3))), controls=Position())
    assert type(runnable_loop(loop).controller.controller.controller.controls) is Force
    assert field_at(loop, "controller.controller.controller.proportional_gain").unit == "V/N"
    assert "proportional_gain 0.001 V/N" in outline(loop)


def written(folder: Path, text: str) -> Path:
    path = folder / "cascade.toml"
    path.write_text(on_base(text), encoding="utf-8")
    return path


def test_a_scenario_has_units_of_both_loops(tmp_path: Path) -> None:
    loop = load_scenario(written(tmp_path, SCENARIO))
    assert_same_block(loop.controller, Cascade(PI(3.0), 20.0, 0.05))
    units = [
        field_at(loop, f"controller.{name}").unit for name in ("proportional_gain", "controller.anti_windup")
    ]
    assert units == ["1/s", "1/s"]
    assert field_at(loop, "controller.controller.integral_gain").unit == "V/m"
    text = SCENARIO.replace("3 V s/m", "3 V/m")
    with pytest.raises(ScenarioError, match=r"controller.controller.proportional_gain.*V s/m"):
        load_scenario(written(tmp_path, text))
    with pytest.raises(ScenarioError, match=r"controller.proportional_gain.*1/s"):
        load_scenario(written(tmp_path, SCENARIO.replace("20 1/s", "20 V/m")))


def test_a_position_is_reached_with_no_more_than_the_largest_velocity(tmp_path: Path) -> None:
    short = {"simulation.duration": "150 ms", "simulation.period": "1 ms", "simulation.substeps": 20}
    quick = {"controller.max_velocity": "20 mm/s", "controller.proportional_gain": "200 1/s"}
    loop = load_scenario(
        written(tmp_path, SCENARIO), short | quick | {"load.type": "Constant", "load.amplitude": 0}
    )
    run = simulate(loop, record=["controller.velocity_demand", "plant.position"], compiled=False)
    assert run["controller.velocity_demand"].attrs["units"] == "m/s"
    assert float(run["controller.velocity_demand"].max()) == 0.02
    assert float(run["plant.position"][-1]) == pytest.approx(0.04, abs=1e-5)
