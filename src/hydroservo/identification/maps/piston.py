"""The piston of which a map is made, and its stretches of constant speed."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ScenarioError
from hydroservo.identification.log import SIGNALS
from hydroservo.identification.segments import Segment, UnderstoodLog, noise_of

Samples = NDArray[np.float64]
TOLERANCE = 0.05  # of the speed, within which it is constant
SIGMAS = 4.0  # deviations of a mean, by which the noise may move it
WINDOW = 5  # samples over which means are taken, at least
PARTS = 500  # windows of a log, at most
FEWEST = 3  # windows of a stretch
SEEN = 4  # samples of a stretch in which the velocity is known, of which a slope has a deviation
SWINGS = 0.25  # of the speed, by which the velocity deviates where it sticks and slips
SETTLED = 0.2  # of a stretch, after which friction and pressures have settled


def require_signals(log: UnderstoodLog, signals: Sequence[str], why: str) -> None:
    """Refuse a log that lacks a signal, or in which it never changes."""
    if not any(set(signals) & set(one.measured) for one in log.segments):
        names = " or ".join(f'"{name} [{SIGNALS[name].unit}]"' for name in signals)
        lacking = "changes" if set(signals) & set(log.log.signals) else "is there"
        raise ScenarioError(log.log.name, "", f"no column {names} {lacking}, which {why} needs")


def stretch_velocity(one: Segment) -> Samples:
    """The velocity in a stretch [m/s]: measured, or the slope of the position."""
    if "velocity" in one.measured:
        return one.measured["velocity"]
    return np.gradient(one.measured["position"], one.period)


def bridge_gaps(values: Samples, log: int) -> Samples:
    """A signal with straight lines over what is missing."""
    places, there = np.arange(values.size), np.isfinite(values)
    if not there.any():
        raise ScenarioError(
            f"log {log + 1}",
            "",
            "a signal is missing throughout a stretch between two gaps: cut that stretch out",
        )
    found: Samples = np.interp(places, places[there], values[there])
    return found


class Piston(NamedTuple):
    """The piston of a plant."""

    plant: Any  # the plant
    area_a: float  # of chamber A [m^2]
    area_b: float  # of chamber B [m^2]

    @property
    def has_chambers(self) -> bool:
        """Whether it is a cylinder with two chambers, and not one described by its load pressure."""
        return hasattr(self.plant, "volume_a")

    def volumes(self, position: Samples) -> tuple[Samples, Samples]:
        """V_A and V_B [m^3]; of a plant described by its load pressure, half of V_t each."""
        if not self.has_chambers:
            half = np.full(position.size, 0.5 * self.plant.total_volume)
            return half, half
        a, b = zip(
            *((self.plant.volume_a(x), self.plant.volume_b(x)) for x in position.tolist()), strict=True
        )
        return np.array(a), np.array(b)

    def inertia(self, position: float) -> float:
        """The moving mass [kg]."""
        if not self.has_chambers:
            return float(self.plant.mass)
        carried = self.plant.carried
        return float(carried.inertia(carried.init(), self.plant.mechanism, position))

    def resistance(self, position: float, velocity: float) -> float:
        """What the mechanism resists with at a steady speed, without friction of the piston [N]."""
        if not self.has_chambers:
            return 0.0
        carried = self.plant.carried
        return float(carried.resistance(carried.init(), self.plant.mechanism, position, velocity))


def piston_of(plant: Any, scenario: str) -> Piston:
    """The piston of a scenario's plant."""
    if hasattr(plant, "piston_area") and hasattr(plant, "total_volume"):
        return Piston(plant, plant.piston_area, plant.piston_area)
    if hasattr(plant, "volume_a") and hasattr(plant, "area_a"):
        return Piston(plant, plant.area_a, plant.area_b)
    problem = f"{type(plant).__name__} has no piston areas and volumes; Cylinder and LoadPressurePlant have"
    raise ScenarioError(scenario, "plant.type", problem)


class SteadyStretch(NamedTuple):
    """A stretch of constant speed."""

    part: slice  # its samples, settled
    speed: float  # with its sign [m/s]
    acceleration: float  # that is left [m/s^2]
    deviation: float  # of it, its standard deviation [m/s^2]


def steady_stretches(one: Segment) -> Iterator[SteadyStretch]:
    """The stretches of constant speed in one without gaps; none in which the machine sticks and slips."""
    velocity = stretch_velocity(one)
    noise = noise_of(velocity)
    width, smooth, deviation = smooth_velocity(velocity, one.log)
    for first, last in constant_spans(smooth, width, deviation):
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
        yield SteadyStretch(part, float(v[there].mean()), float(slope), float(np.sqrt(covariance[0, 0])))


def longest_stretch(one: Segment) -> float:
    """How long the longest stretch is, and one that is too short too [s]."""
    width, smooth, deviation = smooth_velocity(stretch_velocity(one), one.log)
    found = [last - first for first, last in constant_spans(smooth, width, deviation, 1)]
    return one.period * max(found, default=0)


def smooth_velocity(velocity: Samples, log: int) -> tuple[int, Samples, float]:
    """The window of means, the velocity as means over it, and the deviation that noise leaves of one."""
    width = max(WINDOW, velocity.size // PARTS)
    smooth: Samples = np.convolve(bridge_gaps(velocity, log), np.full(width, 1.0 / width), mode="same")
    return width, smooth, noise_of(velocity) / float(np.sqrt(width))


def constant_spans(
    smooth: Samples, width: int, deviation: float, fewest: int = FEWEST
) -> Iterator[tuple[int, int]]:
    """First and last sample of each stretch, from a smooth velocity."""
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
