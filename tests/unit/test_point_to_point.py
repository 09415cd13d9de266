"""A move with limited rates, against its integrated third rate and closed forms of its duration."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.control.references import PointToPoint
from hydroservo.control.references.point_to_point import Limits

SLACK = 1e-11  # of rounding, relative to a limit

values = st.floats(-1.0, 1.0)
limits = st.tuples(st.floats(0.01, 10.0), st.floats(0.1, 100.0), st.floats(1.0, 1e4))


def duration(block: PointToPoint) -> float:
    """How long the move is, by bisection of the instant from which it stands at its end."""
    low, high = block.time, block.time + 1e3
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if block.at(middle)[:2] == (block.final, 0.0) else (middle, high)
    return high - block.time


@pytest.mark.parametrize(
    ("way", "rate", "second", "third", "expected"),
    [
        (1.0, 0.5, 1.0, 4.0, 1.0 / 0.5 + 0.5 / 1.0 + 1.0 / 4.0),  # all seven sections: h/V + V/A + A/J
        (1.0, 0.5, 100.0, 4.0, 1.0 / 0.5 + 2.0 * math.sqrt(0.5 / 4.0)),  # no constant second rate
        (1.0, 100.0, 1.0, 4.0, 0.25 + math.sqrt(0.25**2 + 4.0 * 1.0)),  # no cruise
        (1.0, 100.0, 100.0, 4.0, (32.0 * 1.0 / 4.0) ** (1.0 / 3.0)),  # the third limit alone
    ],
)
def test_the_duration_is_that_of_the_closed_form(
    way: float, rate: float, second: float, third: float, expected: float
) -> None:
    for block in (
        PointToPoint(0.2, 0.2 + way, rate, second, third),
        PointToPoint(-0.2, -0.2 - way, rate, second, third),
    ):
        assert duration(block) == pytest.approx(expected, rel=1e-5)  # the end is flat, cubic in time left


@pytest.mark.parametrize(
    "limit", [(0.5, 1.0, 4.0), (0.5, 100.0, 4.0), (100.0, 1.0, 4.0), (100.0, 100.0, 4.0)]
)
def test_the_third_rate_integrated_is_the_move(limit: tuple[float, float, float]) -> None:
    """Bang-bang third rate of the sections, from textbook times, integrated by small exact steps."""
    block = PointToPoint(0.0, 1.0, *limit, time=0.0)
    jerking, steady, cruise = sections(1.0, *limit)
    lengths = [jerking, steady, jerking, cruise, jerking, steady, jerking]
    signs = [1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0]
    x = v = a = t = 0.0
    for length, sign in zip(lengths, signs, strict=True):
        h, j = length / 50, sign * limit[2]
        for _ in range(50):
            x, v, a = x + h * (v + h * (a / 2 + h * j / 6)), v + h * (a + h * j / 2), a + h * j
            t += h
            assert block.at(t) == pytest.approx((x, v, a), abs=1e-11)
    assert x == pytest.approx(1.0, abs=1e-12)


def sections(h: float, rate: float, second: float, third: float) -> tuple[float, float, float]:
    """The sections of a move by cases, as textbooks have it."""
    if rate * third >= second**2:
        jerking, rising = second / third, second / third + rate / second
    else:
        jerking = math.sqrt(rate / third)
        rising = 2.0 * jerking
    if h >= rate * rising:
        return jerking, rising - 2.0 * jerking, h / rate - rising
    jerking = second / third
    rising = 0.5 * (jerking + math.sqrt(jerking**2 + 4.0 * h / second))
    if rising < 2.0 * jerking:
        jerking = (h / (2.0 * third)) ** (1.0 / 3.0)
        rising = 2.0 * jerking
    return jerking, rising - 2.0 * jerking, 0.0


@given(initial=values, final=values, limit=limits)
def test_limits_hold_and_the_move_never_turns(
    initial: float, final: float, limit: tuple[float, float, float]
) -> None:
    block = PointToPoint(initial, final, *limit, time=0.25)
    total = Limits(*limit).sections(abs(final - initial)).total
    instants = np.linspace(0.0, 0.5 + total, 301)
    demands = np.array([block.at(float(t)) for t in instants])
    assert np.abs(demands[:, 1]).max() <= limit[0] * (1.0 + SLACK)
    assert np.abs(demands[:, 2]).max() <= limit[1] * (1.0 + SLACK)
    assert np.abs(np.diff(demands[:, 2]) / np.diff(instants)).max() <= limit[2] * (1.0 + 1e-6)
    assert (math.copysign(1.0, final - initial) * np.diff(demands[:, 0])).min() >= -1e-15
    assert tuple(demands[0]) == (initial, 0.0, 0.0)
    assert tuple(demands[-1]) == (final, 0.0, 0.0)


@given(initial=values, final=values, limit=limits, share=st.floats(0.01, 0.99))
def test_rates_are_derivatives_and_halves_mirror(
    initial: float, final: float, limit: tuple[float, float, float], share: float
) -> None:
    block = PointToPoint(initial, final, *limit, time=0.0)
    total = Limits(*limit).sections(abs(final - initial)).total
    t, h = share * total, 1e-4 * total
    before, demand, after = block.at(t - h), block.at(t), block.at(t + h)
    bend = limit[2] * h
    rounding = 1e-15 / max(h, 1e-15)
    assert (after.value - before.value) / 2 == pytest.approx(
        h * demand.rate, abs=bend * h * h + 1e-15, rel=1e-9
    )
    slope = (after.rate - before.rate) / (2 * h) if h > 0.0 else 0.0
    assert slope == pytest.approx(demand.second_rate, abs=bend + limit[0] * rounding)
    mirror = block.at(total - t)
    assert mirror.value - initial == pytest.approx(final - demand.value, abs=1e-11)
    assert mirror.rate == pytest.approx(demand.rate, abs=1e-9 * limit[0])


def test_a_move_to_where_it_is_stays() -> None:
    block = PointToPoint(0.3, 0.3, 1.0, 1.0, 1.0)
    assert [block.at(t) for t in (0.0, 0.1, 5.0)] == [(0.3, 0.0, 0.0)] * 3


@pytest.mark.parametrize(("final", "third"), [(5e-324, 1.0), (1e-312, 1e12)])
def test_a_move_below_what_numbers_can_divide_is_done_at_once(final: float, third: float) -> None:
    block = PointToPoint(0.0, final, 1.0, 1.0, third)
    assert block.at(0.05) == (0.0, 0.0, 0.0)
    assert block.at(0.1) == block.at(0.2) == (final, 0.0, 0.0)
