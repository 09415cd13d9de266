"""Slow sweeps of a command, up and down, and what answered."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.audits.facts import LoopFacts
from hydroservo.block import replace
from hydroservo.errors import ScenarioError
from hydroservo.formatting import MINUS, quantity
from hydroservo.identification.maps.reading import runs_of
from hydroservo.identification.maps.regression import mean_of
from hydroservo.identification.maps.result import Interval, curve_of
from hydroservo.loop import Loop

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["DENSE", "Pass", "check_slow", "hysteresis_of", "mean_rate", "passes", "span_of", "swept_curve"]

DENSE = 50_000  # samples of a stretch that count
BINS = 60  # over the span of the command
FEWEST = 8  # samples of a pass
LEAST = 0.05  # of the span, that a pass goes
NOTED = 0.1  # of the hysteresis, from which on it is said what of it is lag

Samples = NDArray[np.float64]


class Pass(NamedTuple):
    """A stretch in which the command goes one way.

    Attributes:
        rising: whether it rises.
        rate: the size of the command's rate [V/s], shape (n,).
        command: [V], shape (n,).
        answer: what was measured, shape (n,).
    """

    rising: bool
    rate: Samples
    command: Samples
    answer: Samples


def passes(period: float, command: Samples, answer: Samples) -> Iterator[Pass]:
    """The passes of a stretch, without samples at which nothing was measured.

    Args:
        period: between samples [s].
        command: [V], shape (n,).
        answer: shape (n,); nan where nothing was measured.
    """
    change = np.gradient(command)
    least = 1e-3 * np.abs(change).max()
    for rising in (True, False):
        for part in runs_of(change > least if rising else change < -least):
            there = np.isfinite(answer[part])
            u, y = command[part][there], answer[part][there]
            if u.size >= FEWEST and np.ptp(u) > LEAST * np.ptp(command):
                yield Pass(rising, np.abs(change[part][there]) / period, u, y)


def span_of(sweeps: Sequence[Pass], name: str) -> float:
    """How far the command goes [V].

    Raises:
        ScenarioError: it does not go both ways.
    """
    ways = {one.rising for one in sweeps}
    if ways != {True, False}:
        missing = "no slow sweep" if not ways else "a sweep one way only"
        problem = f"has {missing}: the command must rise and fall over the same range"
        raise ScenarioError(name, "command", problem)
    every = np.concatenate([one.command for one in sweeps])
    return float(np.ptp(every))


def swept_curve(sweeps: Sequence[Pass], name: str, unit: str, meaning: str) -> "xr.Dataset":
    """The mean answer at each command, rising and falling, with its scatter and 95 % interval.

    The scatter is what is left of a straight line through the samples around a point.

    Args:
        sweeps: the passes.
        name: of the answer.
        unit: of the answer, SI.
        meaning: of the answer.
    """
    every = np.concatenate([one.command for one in sweeps])
    edges = np.linspace(every.min(), every.max(), BINS + 1)
    rows: list[tuple[float, ...]] = []
    for rising in (True, False):
        for low, high in pairwise(edges.tolist()):
            inside = [
                (one.command[here], one.answer[here])
                for one in sweeps
                if one.rising == rising
                for here in [(one.command >= low) & (one.command <= high)]
                if here.sum() > 1
            ]
            if inside:
                middle = 0.5 * (low + high)
                rows.append((middle, *at_middle(inside, middle), float(rising)))
    columns = np.array(rows).T
    about = {
        "command": ("V", "command"),
        name: (unit, meaning),
        f"{name}_deviation": (unit, "standard deviation of samples"),
        f"{name}_half": (unit, "half of the 95 % interval of the mean"),
        "rising": ("", "1: the command rises, 0: it falls"),
    }
    return curve_of(dict(zip(about, columns, strict=True)), about)


def at_middle(inside: Sequence[tuple[Samples, Samples]], middle: float) -> tuple[float, float, float]:
    """The mean answer at a command, with its scatter and half its interval."""
    u, y = (np.concatenate(rows) for rows in zip(*inside, strict=True))
    slope = float(np.polyfit(u - middle, y, 1)[0]) if np.ptp(u) > 0.0 else 0.0
    return mean_of([answer - slope * (command - middle) for command, answer in inside])


def lag_of(loop: Loop | None) -> float:
    """The time by which a scenario's valve is behind its command [s]; 0 where none is known.

    A command that is held from sample to sample comes half a period late on the mean, and by its delay. A
    sweep goes one way, so that the play of a hysteresis adds none.
    """
    if loop is None:
        return 0.0
    if hasattr(loop.valve, "hysteresis"):
        loop = replace(loop, {"valve.hysteresis": 0.0})
    facts = LoopFacts(loop, loop, None, None)
    lag = facts.valve_lag + facts.delay + 0.5 * float(loop.simulation.period)
    return lag if np.isfinite(lag) else 0.0


def mean_rate(sweeps: Sequence[Pass], on: Callable[[Samples], NDArray[np.bool_]] | None = None) -> float:
    """The mean size of the command's rate [V/s], over all samples or those whose answer counts."""
    every = [one.rate if on is None else one.rate[on(one.answer)] for one in sweeps]
    return float(np.concatenate(every).mean())


def hysteresis_of(
    apart: tuple[float, float], rate: float, loop: Loop | None
) -> tuple[dict[str, Interval], list[str]]:
    """The hysteresis: by how much the curves of both directions lie apart, less what the valve's lag makes.

    Where the valve's lag alone explains the width, there is no number, and a remark says so.

    Args:
        apart: the width and half its interval [V].
        rate: the mean size of the command's rate where that was measured [V/s].
        loop: of the scenario.
    """
    lag = 2.0 * lag_of(loop) * rate
    width = Interval.around(apart[0] - lag, apart[1], "V", "full width of the hysteresis")
    if width.high >= 0.0:
        return {"hysteresis": width.at_least_0()}, []
    shown, made = (quantity(one, "V").replace(MINUS, "-") for one in (apart[0], lag))
    return {}, [f"hysteresis cannot be determined: directions lie {shown} apart, and the lag makes {made}"]


def check_slow(
    apart: float, widest: float, sweeps: Sequence[Pass], loop: Loop | None, name: str
) -> Iterator[str]:
    """What there is to say of how fast the command was swept.

    Args:
        apart: the width between both directions [V].
        widest: share of the command's span that they may lie apart.
        sweeps: the passes.
        loop: of the scenario.
        name: of the log.

    Raises:
        ScenarioError: it was too fast.
    """
    span = span_of(sweeps, name)
    rate, lag = mean_rate(sweeps), lag_of(loop)
    shown = quantity(apart, "V").replace(MINUS, "-")
    made = quantity(2.0 * lag * rate, "V")
    by_lag = f"; the lag of valve and sampling, {quantity(lag, 's')}, makes {made} of it"
    said = by_lag if lag else ""
    if abs(apart) > widest * span:
        problem = (
            f"rises and falls {shown} apart, {100.0 * abs(apart) / span:.2g} % of its span: the sweep is too "
            f"fast at {quantity(rate, 'V')}/s{said}; at most {100.0 * widest:.0f} % are a static map"
        )
        raise ScenarioError(name, "command", problem)
    if 2.0 * lag * rate > NOTED * abs(apart):
        yield f"both directions lie {shown} apart{said}, which is taken off; a slower sweep shows it better"
