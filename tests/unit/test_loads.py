"""Loads at instants where their value is plain."""

import pytest

from hydroservo import references
from hydroservo.core.time_series import TimeSeries
from hydroservo.machine.loads import Constant, Recorded, Sine, Square, Step
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block


def test_the_defaults_are_the_papers() -> None:
    """100 sin(0.5 pi t) N with the sine demand, 100 N with the square one."""
    assert example(Sine).force(1.0) == pytest.approx(100.0)
    assert example(Sine).force(3.0) == pytest.approx(-100.0)
    assert example(Constant).force(0.0) == 100.0
    assert example(Constant).force(7.0) == 100.0


def test_square() -> None:
    load = Square(10.0, 2.0, 5.0)
    assert [load.force(t) for t in (0.0, 0.99, 1.0, 1.99, 2.0)] == [15.0, 15.0, -5.0, -5.0, 15.0]


def test_step() -> None:
    load = Step(-10.0, 40.0, 0.25)
    assert [load.force(t) for t in (0.0, 0.2499, 0.25, 5.0)] == [-10.0, -10.0, 40.0, 40.0]


def test_recorded() -> None:
    load = Recorded(TimeSeries.from_samples([0.0, 0.5, 1.0], [1.0, 3.0, -2.0]))
    assert [load.force(t) for t in (-1.0, 0.0, 0.5, 1.0, 9.0)] == pytest.approx([1.0, 1.0, 3.0, -2.0, -2.0])


def test_the_default_record_is_zero() -> None:
    assert Recorded().force(0.3) == 0.0


def test_a_load_is_no_demand_with_the_same_numbers() -> None:
    load, demand = example(Sine), references.Sine(*example(Sine))
    assert load == demand
    with pytest.raises(AssertionError):
        assert_same_block(load, demand)
