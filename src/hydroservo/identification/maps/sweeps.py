"""Slow sweeps of a command, up and down, and what answered."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ScenarioError
from hydroservo.identification.maps.result import curve_of
from hydroservo.identification.regression import mean_of

if TYPE_CHECKING:
    import xarray as xr

DENSE = 50_000  # samples of a stretch that count
BINS = 60  # over the span of the command
FEWEST = 8  # samples of a pass
LEAST = 0.05  # of the span, that a pass goes
PLAY = 0.1  # of the span, after which a valve has taken up its play
RESTS = 1e-3  # of the largest rate, below which the command rests
WHOLE = 0.8  # of a range, through which a pass goes
NEIGHBOURS = 25  # samples of a mean by which others are chosen
WINDOWS = 50  # of a pass, over each of which a rate is taken

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
    """The passes of a stretch, without samples at which nothing was measured or the command rests.

    Until the command has gone a tenth of its span from a turn, or from its first sample, a valve with play
    may not follow yet: these samples are left out.

    Args:
        period: between samples [s].
        command: [V], shape (n,); it may be noisy, or rise in steps.
        answer: shape (n,); nan where nothing was measured.
    """
    span = float(np.ptp(command))
    least = LEAST * span
    parts = [slice(first, last + 1) for first, last in pairwise(turns(command, least))]
    rates = [rate_of(command[part], period) for part in parts]
    slowest = RESTS * max((float(rate.max()) for rate in rates), default=0.0)
    for part, rate in zip(parts, rates, strict=True):
        follows = np.abs(command[part] - command[part][0]) > PLAY * span
        there = np.isfinite(answer[part]) & (rate > slowest) & follows
        u, y = command[part][there], answer[part][there]
        if u.size >= FEWEST and np.ptp(u) > least:
            yield Pass(bool(command[part][-1] > command[part][0]), rate[there], u, y)


def turns(command: Samples, least: float) -> list[int]:
    """Where a command turns by more than so much, with its first and last sample."""
    found, extreme, way = [0], 0, 0.0
    values = command.tolist()
    for i, u in enumerate(values):
        if way == 0.0:
            way = float(np.sign(u - values[0])) if abs(u - values[0]) > least else 0.0
            extreme = i
        elif way * (u - values[extreme]) >= 0.0:
            extreme = i
        elif way * (values[extreme] - u) > least:
            found.append(extreme)
            extreme, way = i, -way
    return [*found, len(values) - 1] if values else []


def rate_of(command: Samples, period: float) -> Samples:
    """The size of a pass's rate [V/s], of means over a fiftieth of it; 0 where it goes the other way."""
    width = max(command.size // WINDOWS, 1)
    if command.size < 2 * width + 2:
        return np.zeros(command.size)
    edges = np.pad(command, width, mode="reflect", reflect_type="odd")
    smooth = np.convolve(edges, np.full(width, 1.0 / width), mode="same")[width:-width]
    way = np.sign(command[-1] - command[0])
    return np.asarray(np.maximum(way * np.gradient(smooth, period), 0.0))


def span_of(sweeps: Sequence[Pass], name: str) -> float:
    """How far the command goes [V]."""
    ways = {one.rising for one in sweeps}
    if ways != {True, False}:
        missing = "no slow sweep" if not ways else "a sweep one way only"
        problem = f"has {missing}: the command must rise and fall over the same range"
        raise ScenarioError(name, "command", problem)
    every = np.concatenate([one.command for one in sweeps])
    return float(np.ptp(every))


def chosen(sweeps: Sequence[Pass], low: float, high: float) -> list[Pass]:
    """The samples at commands between which the mean answer rises from one value to another.

    Samples chosen by their own answer would be those whose noise suits the choice, and bias a line. A pass
    that goes through a part of the range alone would weigh that part more.
    """
    found = []
    for rising in {one.rising for one in sweeps}:
        command, mean = mean_answer(sweeps, rising)
        first, last = np.interp([low, high], np.maximum.accumulate(mean), command)
        for one in sweeps:
            on = (one.command >= first) & (one.command <= last)
            if one.rising == rising and on.any() and np.ptp(one.command[on]) >= WHOLE * (last - first):
                found.append(Pass(rising, one.rate[on], one.command[on], one.answer[on]))
    return found


def mean_answer(sweeps: Sequence[Pass], rising: bool) -> tuple[Samples, Samples]:
    """Means of neighbours in the command, of one direction: the command and the answer."""
    ways = [one for one in sweeps if one.rising == rising]
    command, answer = (np.concatenate(rows) for rows in zip(*(one[2:] for one in ways), strict=True))
    order = np.argsort(command, kind="stable")
    parts = np.array_split(order, max(order.size // NEIGHBOURS, 1))
    return np.array([command[one].mean() for one in parts]), np.array([answer[one].mean() for one in parts])


def swept_curve(sweeps: Sequence[Pass], name: str, unit: str, meaning: str) -> "xr.Dataset":
    """The mean answer at each command, rising and falling, with its scatter and 95 % interval.

    The scatter is what is left of a straight line through the samples around a point.
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
