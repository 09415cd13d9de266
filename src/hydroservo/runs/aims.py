"""What a search is to make small, and what may be said of it."""

import math
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import judged_by
from hydroservo.core.block import Block, field_at, value_at
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field
from hydroservo.core.nearest import one_of
from hydroservo.core.validation import whole_number, within
from hydroservo.runs.arguments import check_one_signal

ACTIVITY = "control_total_variation"
LARGEST = 1e300  # of weights and effort
WHOLE = {"seeds": (1, 10_000), "candidates": (1, 10_000_000), "seed": (0, 2**63 - 1)}  # ranges by name


class Aim(NamedTuple):
    """What is to be small: the weighted geometric mean of a metric over loops, each its mean over seeds.

    With an ``effort`` e > 0 the metric of each loop is multiplied by its control_total_variation^e, so that a
    calmer command is worth something: with e = 0.1, one a tenth as lively is worth a fifth of the metric.

    Attributes:
        loops: the loops, all with the same controller.
        weights: of each loop's metric in the geometric mean; alike if none are given.
        metric: name of a metric of which less is better, such as those of
            :class:`~hydroservo.control.monitors.TrackingError`; another name is refused with those that there
            are.
        seeds: how many seeds each candidate is simulated with, from the loop's own on.
        effort: exponent e of the command's total variation, at least 0.
        metrics: the monitors that the metric comes from, in place of the loops' own, as of
            :func:`~hydroservo.simulate`; the loops' own if None.
    """

    loops: Sequence[Loop]
    weights: Sequence[float] = ()
    metric: str = "rms_error"
    seeds: int = 1
    effort: float = 0.0
    metrics: Mapping[str, Block] | Sequence[Block] | None = None


def checked_aim(aim: Aim) -> Aim:
    """An aim with a weight for each of its loops."""
    check_one_signal("loops", [loop.controls.declared().meaning for loop in aim.loops])
    metric_field(aim.loops, aim.metric)
    count = len(aim.loops)
    none = isinstance(aim.weights, list | tuple) and not aim.weights
    weights = (1.0,) * count if none else checked_weights(aim.weights, count, "loop")
    seeds, effort = checked_whole("seeds", aim.seeds), checked_effort(aim.effort)
    if effort and ACTIVITY not in judged_by(aim.loops):
        raise ParameterError("effort", effort, f"must be 0 for a loop without the metric {ACTIVITY}")
    return aim._replace(weights=weights, seeds=seeds, effort=effort)


def metric_field(loops: Sequence[Loop], metric: object) -> Field:
    """The declaration of a metric that loops can be tuned by."""
    if not isinstance(metric, str):
        raise ParameterError("metric", metric, "must be the name of a metric")
    known = judged_by(loops)
    if metric not in known:
        raise ParameterError("metric", metric, one_of(metric, known))
    return known[metric]


def checked_weights(value: object, count: int, each: str) -> tuple[float, ...]:
    """Weights in a geometric mean.

    Args:
        value: the weights.
        count: how many there must be.
        each: what each is for, in a word.
    """
    found = finite_numbers(value)
    if len(found) != count or min(found) <= 0.0:
        raise ParameterError("weights", value, f"must be a number above 0 for each {each}; there are {count}")
    return found


def checked_effort(value: object) -> float:
    """An exponent of the command's total variation."""
    found = finite_numbers([value])
    if not found or found[0] < 0.0:
        raise ParameterError("effort", value, "must be a finite number, at least 0")
    return found[0]


def checked_whole(name: str, value: object) -> int:
    """The number of seeds or candidates, or the seed of a search."""
    return whole_number(name, value, *WHOLE[name])


def finite_numbers(value: object) -> tuple[float, ...]:
    """The numbers in a list; none where it holds anything but finite numbers, or is no list."""
    found = tuple(value) if isinstance(value, (list, tuple, np.ndarray)) else ()
    return tuple(map(float, found)) if all(map(is_finite, found)) else ()


def is_finite(value: Any) -> bool:
    number = isinstance(value, Real) and not isinstance(value, bool)
    return number and bool(abs(value) < LARGEST)


def check_ranges(loops: Sequence[Loop], ranges: Mapping[str, tuple[float, float]]) -> None:
    """Refuse what is no range of a number that all loops have."""
    if not ranges:
        raise ParameterError("ranges", "{}", "must name at least one parameter")
    for path, ends in ranges.items():
        pair = finite_numbers(ends)
        for loop in loops:
            try:
                present, field = value_at(loop, path), field_at(loop, path)
            except ParameterError as error:
                raise ParameterError("ranges", path, error.allowed) from None
            if not isinstance(present, float):
                raise ParameterError("ranges", path, "must be the path of a float")
            if len(pair) != 2 or not (pair[0] < pair[1] and all(within(end, field) for end in pair)):
                raise ParameterError(path, ends, "must be a range of allowed values, low before high")


def geometric_mean(weights: Sequence[float], metrics: Sequence[float]) -> float:
    """The weighted geometric mean of the loops' metrics; inf where a run was lost."""
    pairs = zip(weights, metrics, strict=True)
    return float(math.prod(metric ** (weight / math.fsum(weights)) for weight, metric in pairs))
