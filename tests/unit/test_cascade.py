"""Position over velocity: what the nested law is given, in which units, and what it comes to."""

from pathlib import Path
from typing import Annotated, NamedTuple

import pytest

from hydroservo import Field, Loop, ParameterError, ScenarioError, simulate
from hydroservo.block import field_at
from hydroservo.controlled import Force, Position, Velocity
from hydroservo.controllers import PI, PID, TSMC, Cascade, Saturation
from hydroservo.outline import outline
from hydroservo.scenario import load_scenario
from hydroservo.signals import Demand, Measurement
from hydroservo.testing.examples import example
from hydroservo.wiring import wired
from tests.support.bases import on_base

H = 1e-3
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
    loop = wired(example(Loop, controller=example(Cascade), controls=Position()))
    assert loop.controller.controls == Position()
    assert loop.controller.controller.controls == Velocity()
    assert wired(loop) == loop


def test_a_law_for_velocities_alone_holds_a_position_inside() -> None:
    """The first paper's law, which a position loop refuses by itself."""
    loop = example(Loop, controller=example(TSMC), controls=Position())
    with pytest.raises(ParameterError, match="controls the velocity, and here the position is controlled"):
        wired(loop)
    assert wired(loop._replace(controller=example(Cascade, example(TSMC)))).controller.controls == Position()


@pytest.mark.parametrize(("controls", "units"), [(Position(), ("1/s", "")), (Force(), ("m/(s N)", "m/N"))])
def test_units_are_those_of_each_loop(controls: Position | Force, units: tuple[str, str]) -> None:
    loop = wired(example(Loop, controller=example(Cascade), controls=controls))
    names = ("proportional_gain", "rate_feedforward", "controller.proportional_gain")
    assert [field_at(loop, f"controller.{name}").unit for name in names] == [*units, "V s/m"]
    assert f"proportional_gain 10 {units[0]}" in outline(loop)


def written(folder: Path, text: str) -> Path:
    path = folder / "cascade.toml"
    path.write_text(on_base(text), encoding="utf-8")
    return path


def test_a_scenario_has_units_of_both_loops(tmp_path: Path) -> None:
    loop = load_scenario(written(tmp_path, SCENARIO))
    assert loop.controller == Cascade(PI(3.0), 20.0, 0.05)
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
