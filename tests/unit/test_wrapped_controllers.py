"""What wrappers do to a command, and what they leave alone."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import Field, Loop, ScenarioError, Simulation, simulate
from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import (
    DAC,
    PI,
    TSMC,
    AntiWindup,
    Backstepping,
    Delay,
    RateLimit,
    Saturation,
)
from hydroservo.control.observers import Implicit, TSMObserver
from hydroservo.control.wiring import with_signal
from hydroservo.core.block import Block, model_in, value_at
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import on_base

H = 1e-3
WIDE = Saturation(1e6)
commands = st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=20)


class ToldState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class Told(NamedTuple):
    """A law that asks for what the demand says."""

    def init(self) -> ToldState:
        return ToldState(0.0)

    def step(self, s: ToldState, y: Measurement, r: Demand, dt: float) -> ToldState:
        return ToldState(r.value)


def given_out(law: Any, demands: Sequence[float], velocities: Sequence[float] = ()) -> list[float]:
    """The commands of a law whose outermost one is applied at once."""
    law = with_signal(law, Velocity())
    s, found, seen = law.init(), [], velocities or [0.0] * len(demands)
    for demand, velocity in zip(demands, seen, strict=True):
        y = Measurement(velocity, 0.0, 0.0, s.u, 0.0, 0.0, 0.0)
        s = law.step(s, y, Demand(demand, 0.0, 0.0), H)
        found.append(s.u)
    return found


# Converter


@given(commands, st.integers(2, 16))
def test_a_converter_puts_out_whole_steps_within_its_range(asked: list[float], bits: int) -> None:
    step = 20.0 / 2**bits
    for u, wanted in zip(given_out(DAC(Told(), bits), asked), asked, strict=True):
        assert u / step == round(u / step)
        assert -10.0 <= u <= 10.0 - step
        assert abs(u - min(max(wanted, -10.0), 10.0 - step)) <= 0.5 * step * (1.0 + 1e-12)


def test_a_converter_of_three_bits_has_eight_levels() -> None:
    asked = np.linspace(-12.0, 12.0, 1001).tolist()
    assert sorted(set(given_out(DAC(Told(), 3, 8.0), asked))) == [-8.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0]


def test_a_command_that_is_not_a_number_stays_one() -> None:
    for law in (DAC(Told()), example(RateLimit, Told()), example(AntiWindup, Told())):
        assert math.isnan(given_out(law, [math.nan])[0])


# Rate limit and delay


@given(commands)
def test_a_rate_limit_limits_the_rate_and_nothing_else(asked: list[float]) -> None:
    most, last = 2000.0 * H, 0.0
    for u, wanted in zip(given_out(RateLimit(Told(), 2000.0), asked), asked, strict=True):
        assert abs(u - last) <= most * (1.0 + 1e-12)
        assert u == pytest.approx(wanted, abs=1e-12) or abs(u - last) == pytest.approx(most)
        assert abs(wanted - u) <= abs(wanted - last)
        last = u


@given(commands)
def test_a_delay_is_of_one_sample_exactly(asked: list[float]) -> None:
    assert given_out(Delay(Told()), asked) == [0.0, *asked][: len(asked)]
    assert given_out(Delay(Delay(Told())), asked) == [0.0, 0.0, *asked][: len(asked)]


def test_a_law_learns_what_was_put_out() -> None:
    """PI's own back-calculation counts what the converter takes away."""
    law = PI(1.0, 0.0, anti_windup=100.0, saturation=WIDE, controls=Velocity())
    first, second = given_out(DAC(law), [25.0, 25.0])
    assert first == 10.0 - 20.0 / 2**12
    s = DAC(law).init()
    for _ in range(2):
        s = DAC(law).step(s, Measurement(0.0, 0.0, 0.0, s.u, 0.0, 0.0, 0.0), Demand(25.0, 0.0, 0.0), H)
    assert s.u == second
    assert s.controller.integral == pytest.approx(H * 100.0 * (first - 25.0))


# Anti-windup


@given(
    demands=st.lists(st.floats(-1.0, 1.0), min_size=30, max_size=30),
    velocities=st.lists(st.floats(-1.0, 1.0), min_size=30, max_size=30),
    proportional=st.floats(1.0, 100.0),
    integral=st.floats(0.0, 1e3),
    gain=st.floats(1.0, 100.0),
)
def test_around_a_pi_it_is_back_calculation(
    demands: list[float], velocities: list[float], proportional: float, integral: float, gain: float
) -> None:
    around = AntiWindup(PI(proportional, integral, saturation=WIDE), gain)
    inside = PI(proportional, integral, anti_windup=integral / gain)
    found = given_out(around, demands, velocities)
    assert found == pytest.approx(given_out(inside, demands, velocities), rel=1e-9, abs=1e-9)
    free = inside._replace(saturation=WIDE)
    limited = given_out(RateLimit(around._replace(saturation=WIDE), 500.0), demands, velocities)
    assert limited == pytest.approx(
        given_out(RateLimit(free, 500.0), demands, velocities), rel=1e-9, abs=1e-9
    )


@given(
    st.lists(st.floats(-0.05, 0.05), min_size=30, max_size=30),
    st.lists(st.floats(-0.05, 0.05), min_size=30, max_size=30),
)
def test_while_nothing_limits_the_law_runs_as_if_it_were_alone(
    demands: list[float], velocities: list[float]
) -> None:
    law = PI(50.0, 100.0, saturation=WIDE)
    assert given_out(AntiWindup(law, 3.0), demands, velocities) == given_out(law, demands, velocities)


def overshoot(law: Any) -> float:
    """Of a body that 10 V accelerate by 1 m/s^2, when 1 m/s is asked of it."""
    law = with_signal(law, Velocity())
    s, velocity, largest = law.init(), 0.0, 0.0
    for _ in range(10_000):
        s = law.step(s, Measurement(velocity, 0.0, 0.0, s.u, 0.0, 0.0, 0.0), Demand(1.0, 0.0, 0.0), H)
        velocity += H * 0.1 * s.u
        largest = max(largest, velocity)
    return largest - 1.0


def test_the_overshoot_after_a_long_saturation_goes() -> None:
    """What is left is what the law has from rest without any limit, and that of PI's own back-calculation."""
    winding, unlimited = overshoot(PI(100.0, 250.0)), overshoot(PI(100.0, 250.0, saturation=WIDE))
    around = overshoot(AntiWindup(PI(100.0, 250.0, saturation=WIDE), 100.0))
    assert winding > 4.0 * unlimited
    assert around < unlimited
    assert around == pytest.approx(overshoot(PI(100.0, 250.0, anti_windup=2.5)), abs=1e-9)


@pytest.mark.parametrize("gain", [50.0, 200.0])
def test_a_gain_that_is_off_by_two_still_helps(gain: float) -> None:
    winding = overshoot(PI(100.0, 250.0))
    assert overshoot(AntiWindup(PI(100.0, 250.0, saturation=WIDE), gain)) < 0.5 * winding


def test_rates_of_the_demand_are_left_alone() -> None:
    class Rates(NamedTuple):
        def init(self) -> Demand:
            return Demand(0.0, 0.0, 0.0)

        def step(self, s: Demand, y: Measurement, r: Demand, dt: float) -> Any:
            assert r.rate in (0.0, 7.0)
            assert r.second_rate in (0.0, -3.0)
            return Seen(100.0, r.value)

    class Seen(NamedTuple):
        u: float
        value: float

    law: Any = AntiWindup(Rates(), 10.0)
    s = law.init()._replace(controller=Seen(0.0, 0.0), before=Seen(0.0, 0.0))
    for _ in range(3):
        s = law.step(s, Measurement(0.0, 0.0, 0.0, s.u, 0.0, 0.0, 0.0), Demand(1.0, 7.0, -3.0), H)
    assert s.before.value == 1.0 + (10.0 - 100.0) / 10.0


# What is found through wrappers


@pytest.fixture(scope="module")
def watched() -> Any:
    law = example(
        TSMC, 30.0, 30.0, observer=example(TSMObserver, switching_gain_2=1e5, realisation=Implicit())
    )
    return simulate(
        example(Loop, Simulation(0.2, H, 8, record_period=H), controller=DAC(example(RateLimit, law)))
    )


def test_metrics_find_the_estimates(watched: Any) -> None:
    for i in (1, 2):
        error = watched[f"controller.controller.controller.observer.d{i}"] - watched[f"disturbance.d{i}"]
        expected = float(np.sqrt((error[100:] ** 2).mean()))  # the second half
        assert float(watched[f"estimate_rms_error_{i}"]) == pytest.approx(expected, rel=1e-9)


def test_metrics_count_the_command_that_goes_out(watched: Any) -> None:
    u = watched["controller.u"].values
    assert float(watched["control_total_variation"]) == pytest.approx(np.abs(np.diff(u)).sum(), rel=1e-9)
    step = 20.0 / 2**12
    assert np.array_equal(u / step, np.round(u / step))
    assert not np.array_equal(u, watched["controller.controller.controller.u"].values)


def written(folder: Path, text: str) -> Path:
    path = folder / "my.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_wrapped_law_believes_in_the_nominal_machine(tmp_path: Path) -> None:
    text = """
        plant.mass = "7 kg"
        uncertainty.plant.mass = "10 %"
        [controller]
        type = "DAC"
        bits = 14
        [controller.controller]
        type = "RateLimit"
        rate = 1000
        [controller.controller.controller]
        type = "Backstepping"
        velocity_gain = 2000
        force_gain = 1000
        model.plant.damping = "40 N s/m"
    """
    loop = load_scenario(written(tmp_path, on_base(text)))
    model = loop.controller.controller.controller.model
    assert loop.plant.mass == pytest.approx(7.7)
    assert model.plant.mass == 7.0
    assert model.plant.damping == 40.0
    assert model_in(loop.controller) is model


class Inverse(NamedTuple):
    """A wrapper with a model of its own."""

    model: DesignModel = example(DesignModel)
    controller: Block = example(TSMC)


@pytest.mark.parametrize(
    ("controller", "path"),
    [
        (example(PI), None),
        (DAC(example(PI)), None),
        (example(TSMC), "controller.model"),
        (DAC(Delay(example(Backstepping))), "controller.controller.controller.model"),
        (DAC(Inverse()), "controller.controller.model"),
    ],
)
def test_where_a_controllers_model_is(controller: Block, path: str | None) -> None:
    assert model_in(controller) is (
        None if path is None else value_at(example(Loop, controller=controller), path)
    )


def test_the_law_inside_an_anti_windup_is_free_to_ask_for_more(tmp_path: Path) -> None:
    """One that is limited as tightly inside would never show what it wants, and is refused."""
    law = 'controller = {type = "AntiWindup", gain = 9, controller = {type = "PI", proportional_gain = 9%s}}'
    loop = load_scenario(written(tmp_path, on_base(law % ", saturation.limit = 1000")))
    assert loop.controller.controller.saturation.limit == 1000.0
    with pytest.raises(
        ScenarioError, match=r"controller.saturation.limit = 10.0: must be above saturation.limit"
    ):
        load_scenario(written(tmp_path, on_base(law % "")))
