"""Stretches of a log in which the machine moves at a constant speed."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.reading import bridged, velocity_of
from hydroservo.identification.segments import Segment
from hydroservo.identification.spikes import noise_of

TOLERANCE = 0.05  # of the speed, within which it is constant
SIGMAS = 4.0  # deviations of a mean, by which the noise may move it
WINDOW = 5  # samples over which means are taken, at least
PARTS = 500  # windows of a log, at most
FEWEST = 3  # windows of a stretch
SEEN = 4  # samples of a stretch in which the velocity is known, of which a slope has a deviation
SWINGS = 0.25  # of the speed, by which the velocity deviates where it sticks and slips
SETTLED = 0.2  # of a stretch, after which friction and pressures have settled

Samples = NDArray[np.float64]


class Stretch(NamedTuple):
    """A stretch of constant speed.

    Attributes:
        part: its samples, settled.
        speed: with its sign [m/s].
        acceleration: that is left [m/s^2].
        deviation: of it, its standard deviation [m/s^2].
    """

    part: slice
    speed: float
    acceleration: float
    deviation: float


def stretches(one: Segment) -> Iterator[Stretch]:
    """The stretches of constant speed in one without gaps; none in which the machine sticks and slips.

    Args:
        one: with a velocity or a position.
    """
    velocity = velocity_of(one)
    noise = noise_of(velocity)
    width, smooth, deviation = smoothed(velocity, one.log)
    for first, last in constant(smooth, width, deviation):
        settled = first + int(SETTLED * (last - first))
        part = slice(settled, last)
        v = velocity[part]
        there = np.isfinite(v)
        if there.sum() < SEEN:
            continue
        swing = float(np.sqrt(max(v[there].var() - noise**2, 0.0)))
        if swing > SWINGS * abs(v[there].mean()):
            continue
        time = one.period * np.arange(v.size)[there]
        (slope, _), covariance = np.polyfit(time, v[there], 1, cov=True)
        yield Stretch(part, float(v[there].mean()), float(slope), float(np.sqrt(covariance[0, 0])))


def longest_of(one: Segment) -> float:
    """How long the longest stretch is, and one that is too short too [s]."""
    width, smooth, deviation = smoothed(velocity_of(one), one.log)
    found = [last - first for first, last in constant(smooth, width, deviation, 1)]
    return one.period * max(found, default=0)


def smoothed(velocity: Samples, log: int) -> tuple[int, Samples, float]:
    """The window of means, the velocity as means over it, and the deviation that noise leaves of one."""
    width = max(WINDOW, velocity.size // PARTS)
    smooth: Samples = np.convolve(bridged(velocity, log), np.full(width, 1.0 / width), mode="same")
    return width, smooth, noise_of(velocity) / float(np.sqrt(width))


def constant(
    smooth: Samples, width: int, deviation: float, fewest: int = FEWEST
) -> Iterator[tuple[int, int]]:
    """First and last sample of each stretch, from a smooth velocity.

    Args:
        smooth: velocity [m/s], shape (n,).
        width: of the means that make it so.
        deviation: that noise leaves of it [m/s].
        fewest: windows of a stretch.
    """
    half = width // 2
    first = half
    while first + fewest * width <= smooth.size - half:
        level = float(np.median(smooth[first : first + width]))
        band = TOLERANCE * abs(level) + SIGMAS * deviation
        beyond = np.flatnonzero(np.abs(smooth[first : smooth.size - half] - level) > band)
        last = first + int(beyond[0]) if beyond.size else smooth.size - half
        moves = abs(level) > 2.0 * SIGMAS * deviation and abs(level) > 0.0
        if moves and last - first >= fewest * width:
            yield first, last
            first = last
        else:
            first += max(half, 1)
