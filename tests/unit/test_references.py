"""Demands at instants where their value is plain; derivatives and bounds are in the properties."""

import math

import pytest

from hydroservo.control.references import Chirp, Multisine, Ramp, Recorded, Sine, Square, Step, ThereAndBack
from hydroservo.core.time_series import TimeSeries
from hydroservo.testing.examples import example


def test_the_default_sine_is_the_papers() -> None:
    """30 sin(0.5 pi t) mm/s."""
    assert example(Sine).at(0.0) == (0.0, pytest.approx(0.03 * 0.5 * math.pi), 0.0)
    assert example(Sine).at(1.0).value == pytest.approx(0.03)
    assert example(Sine).at(1.0).second_rate == pytest.approx(-0.03 * (0.5 * math.pi) ** 2)


def test_the_default_square_is_the_papers() -> None:
    """30 mm/s either way, 4 s, starting with +."""
    assert [example(Square).at(t).value for t in (0.0, 1.99, 2.0, 3.99, 4.0)] == [
        0.03,
        0.03,
        -0.03,
        -0.03,
        0.03,
    ]


def test_step() -> None:
    block = Step(0.01, 0.02, 0.5)
    assert [block.at(t) for t in (0.0, 0.4999, 0.5, 9.0)] == [
        (0.01, 0.0, 0.0),
        (0.01, 0.0, 0.0),
        (0.02, 0.0, 0.0),
        (0.02, 0.0, 0.0),
    ]


def test_a_step_at_zero_is_there_from_the_start() -> None:
    assert Step(0.0, 0.02, 0.0).at(0.0).value == 0.02


@pytest.mark.parametrize(
    ("t", "value", "rate"),
    [(0.5, 0.1, 0.0), (1.0, 0.1, -0.3), (1.5, -0.05, -0.3), (2.0, -0.2, 0.0), (9.0, -0.2, 0.0)],
)
def test_ramp(t: float, value: float, rate: float) -> None:
    assert Ramp(0.1, -0.2, 0.3, 1.0).at(t) == (pytest.approx(value), rate, 0.0)


def test_a_ramp_to_where_it_is_stays() -> None:
    assert Ramp(0.1, 0.1, 1.0, 0.5).at(2.0) == (0.1, 0.0, 0.0)


def test_chirp_passes_the_mean_frequency_half_way() -> None:
    """Over the sweep it makes (f0 + f1)/2 T cycles; at T/2 its frequency is (f0 + f1)/2."""
    block = Chirp(1.0, 1.0, 3.0, 2.0)
    assert block.at(2.0).value == pytest.approx(0.0, abs=1e-14)  # four cycles
    assert block.at(1.0).value == pytest.approx(0.0, abs=1e-14)  # one and a half cycles
    assert block.at(1.0).rate == pytest.approx(-2.0 * math.pi * 2.0)


def test_a_chirp_may_fall() -> None:
    assert Chirp(1.0, 3.0, 1.0, 2.0).at(2.0).rate == pytest.approx(2.0 * math.pi)


def test_a_multisine_of_one_harmonic_is_a_sine() -> None:
    block, sine = Multisine(0.1, 2.0, 1), Sine(0.1 / math.sqrt(2.0), 2.0)
    assert block.at(0.137) == pytest.approx(sine.at(0.137))


def test_a_multisine_repeats_with_its_lowest_frequency() -> None:
    block = Multisine(0.1, 2.0, 7)
    assert block.at(0.637) == pytest.approx(block.at(0.137), abs=1e-9)


def test_recorded_takes_value_and_derivatives_from_the_record() -> None:
    series = TimeSeries.from_samples([0.0, 1.0, 3.0], [0.0, 2.0, 2.0])
    demand = Recorded(series).at(0.5)
    assert demand == (series.value(0.5), series.rate(0.5), series.second_rate(0.5))
    assert demand.rate > 0.0


def test_the_default_record_is_zero() -> None:
    assert [Recorded().at(t) for t in (-1.0, 0.0, 0.5, 1.0, 2.0)] == [(0.0, 0.0, 0.0)] * 5


def test_there_and_back_mirrors_the_nested_demand_in_time() -> None:
    there = Ramp(0.1, 0.3, rate=0.5, time=0.2)
    demand = ThereAndBack(there, turn=1.0)
    for t in (0.0, 0.3, 0.5, 0.9, 1.0):
        value, rate, second_rate = there.at(t)
        assert demand.at(t) == (value, rate, second_rate)
        if t < 1.0:
            assert demand.at(2.0 - t) == pytest.approx((value, -rate, second_rate))
