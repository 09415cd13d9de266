"""The metrics of many runs: machine code asks the monitors, with the bits of plain Python."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from hydroservo import monitors
from hydroservo.core.block import leaves
from hydroservo.runs import evaluation
from hydroservo.runs.evaluation import MANY, compiled_metrics, finisher, interpreted_metrics

RNG = np.random.default_rng(5)


class Sum(NamedTuple):
    total: float = 0.0


class Found(NamedTuple):
    root: float


class Own(NamedTuple):
    """A monitor; what it makes of its sum is told by its class."""

    def init(self) -> Sum:
        return Sum()


class Careful(Own):
    def values(self, s: Sum) -> Found:
        if s.total > 2.0:
            raise ArithmeticError("too much")
        return Found(s.total**0.5)


class Tolerant(Own):
    def values(self, s: Sum) -> Found:
        return Found(float(f"{s.total:.3g}"))  # text, of which machine code has none


def states(monitor: Any) -> Any:
    """Rows of numbers of its state, and one each of none, of what is no number and of what is too large."""
    size = len(list(leaves(monitor.init())))
    rows = RNG.exponential(10.0, (20, size))
    rows[17:] = np.array([0.0, np.nan, np.inf])[:, None]
    return rows


@pytest.mark.parametrize("name", monitors.__all__)
def test_both_ways_have_the_same_bits(name: str) -> None:
    monitor = getattr(monitors, name)()
    rows = states(monitor)
    assert compiled_metrics(monitor)(rows).tobytes() == interpreted_metrics(monitor)(rows).tobytes()


@pytest.mark.parametrize("runs", [1, MANY])
def test_each_monitor_is_given_its_own_numbers(runs: int) -> None:
    watching = {name: getattr(monitors, name)() for name in ("TrackingError", "Energy", "Disturbance")}
    parts = {name: states(one) for name, one in watching.items()}
    inside = sorted(parts, key=lambda name: evaluation.spans_of(watching)[name].start)
    sums = np.concatenate([parts[name] for name in inside], axis=1).T
    expected = np.concatenate(
        [interpreted_metrics(one)(parts[name]) for name, one in watching.items()], axis=1
    ).T
    assert finisher(watching, runs)(sums).tobytes() == expected.tobytes()


def test_what_cannot_be_compiled_is_asked_in_plain_python() -> None:
    rows = np.array([[1.2345], [2.0]])
    assert compiled_metrics(Tolerant())(rows).tolist() == [[1.23], [2.0]]


def test_a_fault_of_a_monitor_is_that_of_plain_python() -> None:
    ask = compiled_metrics(Careful())
    assert ask(np.array([[1.0], [2.0]])).tolist() == [[1.0], [2.0**0.5]]
    with pytest.raises(ArithmeticError, match="too much"):
        ask(np.array([[1.0], [3.0]]))
