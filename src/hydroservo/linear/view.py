"""A loop about a point, and the frequencies at which one looks."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.field import Field
from hydroservo.core.validation import number
from hydroservo.linear.margins import Judged, Margins, margins_at
from hydroservo.linear.onset import oscillation_gain
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.parts import Parts, parts_of
from hydroservo.linear.places import sliding
from hydroservo.linear.response import rates_of
from hydroservo.linear.trusted import Trusted, trusted_margins
from hydroservo.runs.run import complete

Vector = NDArray[np.float64]
Progress = Callable[[float], None]

POINTS = 400  # of a linear curve, evenly by the logarithm
AROUND = np.array([-8.0, -4.0, -2.0, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0])  # half widths
SHARPEST = 1e-3  # damping of a resonance that a curve shows
BELOW, ABOVE = 40.0, 12.0  # a crossover's share at which a picture begins, and its multiple at which it ends
HIGHEST = 0.9  # of Nyquist's frequency
MOST = 10**6  # samples in a period of the lowest frequency


class View(NamedTuple):
    """A loop about a point, and the frequencies at which one looks.

    Attributes:
        asked: the loop as it was asked for.
        point: where it stays.
        slid: whether its hysteresis passes all of the command there.
        parts: its derivatives there.
        judged: its margins.
        trusted: those of them that hold, or those while it moves.
        onset: the factor on its gain from which it oscillates; infinite for none, nan for unknown.
        low: the lowest frequency [Hz].
        high: the highest.
    """

    asked: Loop
    point: OperatingPoint
    slid: bool
    parts: Parts
    judged: Judged
    trusted: Trusted
    onset: float
    low: float
    high: float

    @property
    def grid(self) -> Vector:
        """Frequencies of the picture's curves [Hz]."""
        return self.dense(self.low, self.high)

    @property
    def usual(self) -> Vector:
        """Frequencies from far below the crossover up to Nyquist's [Hz], whatever the picture shows."""
        low, _ = checked_band(None, self.judged.margins, self.point)
        return self.dense(low, HIGHEST * 0.5 / self.point.loop.simulation.period)

    def dense(self, low: float, high: float) -> Vector:
        """Frequencies of a curve [Hz], dense where the loop resonates."""
        rates = rates_of(self.judged.loop)
        width = np.maximum(np.abs(rates.real), SHARPEST * np.abs(rates.imag))  # else a peak without damping
        sharp = (np.abs(rates.imag)[:, np.newaxis] + width[:, np.newaxis] * AROUND).ravel()
        every = np.concatenate([np.geomspace(low, high, POINTS), sharp / (2.0 * math.pi)])
        return np.unique(every[(every >= low) & (every <= high)])


def viewed(
    loop: Loop,
    command: float | None,
    force: float | None,
    band: tuple[float, float] | None,
    progress: Progress | None = None,
) -> View:
    """A loop about a point, as :func:`hydroservo.bode` has it."""
    if force is not None:
        number(force, "force", Field("N", ""), float)
    point, judged, slid = smoothest(loop, command, force)
    parts, _, _ = parts_of(point)
    limits = checked_band(band, judged.margins, point)
    onset = onset_of(loop, progress)
    trusted = trusted_margins(point, judged, loop, onset)
    return View(complete(loop), point, slid, parts, judged, trusted, onset, *limits)


def smoothest(loop: Loop, command: float | None, force: float | None) -> tuple[OperatingPoint, Judged, bool]:
    """A point of a loop, and whether its hysteresis slides there, as it does where the loop has no slope."""
    slid = sliding(loop)
    try:
        point = operating_point(loop, command, force)
        judged = margins_at(point)
    except ParameterError:
        if slid == loop:
            raise
    else:
        if judged.linear or slid == loop:
            return point, judged, False
    point = operating_point(slid, command, force)
    return point, margins_at(point), True


def onset_of(loop: Loop, progress: Progress | None) -> float:
    """From which gain a loop oscillates; nan where it cannot run."""
    try:
        return oscillation_gain(loop, progress=progress)
    except HydroservoError:
        return math.nan


def checked_band(
    band: tuple[float, float] | None, found: Margins, point: OperatingPoint
) -> tuple[float, float]:
    """The lowest and the highest frequency [Hz]."""
    nyquist = 0.5 / point.loop.simulation.period
    if band is None:
        crossed = [w / (2.0 * math.pi) for w in (*found.gain_crossovers, *found.phase_crossovers)]
        inside = [f for f in crossed if 0.0 < f < HIGHEST * nyquist] or [0.05 * nyquist]
        return max(min(inside) / BELOW, nyquist / MOST), min(ABOVE * max(inside), HIGHEST * nyquist)
    low, high = (number(one, "band", Field("Hz", "", above=0), float) for one in band)
    if not low < high:
        raise ParameterError("band", [low, high], "must rise from the lowest to the highest frequency [Hz]")
    if not high < nyquist:
        raise ParameterError("band", high, f"must be below Nyquist's frequency, {nyquist:g} [Hz]")
    return float(low), float(high)
