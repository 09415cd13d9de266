"""Stairs of a command: stretches in which it rests, each with the direction in which it was reached."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.sweeps import FEWEST, LEAST, Pass, turns
from hydroservo.identification.regression import mean_with_interval
from hydroservo.identification.segments import TO_DEVIATION

LEVEL = 2e-3  # of the span, within which the command rests
SIGMAS = 4.0  # deviations of the command's noise, within which it rests
LONGER = 3.0  # times as long as a ramp through the span stays within that
MOST = 0.5  # of the time of a log, that the command of stairs rests
SETTLED = 0.4  # of a stretch, after which valve and pressures have settled
STEADY = 5e-3  # of the largest answer, by which both halves of a settled stretch may differ

Samples = NDArray[np.float64]


def stretches_at_rest(command: Samples) -> list[slice]:
    """Where a command rests; none where it does so for less than half of the time, as in a sweep."""
    span = float(np.ptp(command))
    noise = TO_DEVIATION * float(np.median(np.abs(np.diff(command)))) / np.sqrt(2.0)
    tolerance = max(LEVEL * span, SIGMAS * noise)
    if not span > 2.0 * tolerance:
        return []
    ways = max(len(turns(command, LEAST * span)) - 1, 1)
    least = max(FEWEST, int(LONGER * 2.0 * tolerance / span * command.size / ways))
    parts = [part for part in level_parts(command, tolerance) if part.stop - part.start >= least]
    return parts if sum(part.stop - part.start for part in parts) > MOST * command.size else []


def level_parts(command: Samples, tolerance: float) -> Iterator[slice]:
    """Stretches one after the other, in each of which all samples lie near its median so far [V]."""
    first = 0
    while first < command.size:
        level = float(np.median(command[first : first + FEWEST]))
        beyond = np.flatnonzero(np.abs(command[first:] - level) > tolerance)
        last = first + int(beyond[0]) if beyond.size else command.size
        yield slice(first, max(last, first + 1))
        first = max(last, first + 1)


def stairs(command: Samples, answer: Samples) -> tuple[list[Pass], int]:
    """The settled stretches of constant command as passes of rate 0, and how many have not settled.

    The first stretch is left out, because its direction is unknown.
    """
    found: list[Pass] = []
    unsettled = 0
    parts = stretches_at_rest(command)
    largest = float(np.nanmax(np.abs(answer))) if np.isfinite(answer).any() else 0.0
    levels = [float(np.median(command[part])) for part in parts]
    for before, level, part in zip(levels, levels[1:], parts[1:], strict=False):
        settled = slice(part.start + int(SETTLED * (part.stop - part.start)), part.stop)
        y = answer[settled]
        there = np.isfinite(y)
        if there.sum() < FEWEST:
            continue
        y = y[there]
        if not is_steady(y, STEADY * largest):
            unsettled += 1
            continue
        found.append(Pass(level > before, np.zeros(y.size), np.full(y.size, level), y))
    return found, unsettled


def is_steady(answer: Samples, allowed: float) -> bool:
    """Whether both halves of a stretch have the same mean, within what is allowed and their noise."""
    (first, _, unsure), (last, _, doubtful) = (
        mean_with_interval([half]) for half in np.array_split(answer, 2)
    )
    return abs(last - first) <= allowed + float(np.hypot(unsure, doubtful))
