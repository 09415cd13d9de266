"""What a frequency response crosses, and its peaks."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.linear.open_loop import OpenLoop

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]

POINTS = 2000  # evenly by the logarithm
LOWEST = 1e-6  # of the Nyquist frequency
AROUND = np.concatenate([-np.geomspace(10.0, 1e-2, 12), [0.0], np.geomspace(1e-2, 10.0, 12)])  # half widths
LEVEL = 1e-2  # by how much a response may change from the lowest frequency to 0
INFINITE = 1e9  # a gain that only an undamped pole has, at which the phase jumps


class Crossings(NamedTuple):
    """Where a loop's response crosses the unit circle, and where the negative real axis.

    Attributes:
        gain: frequencies [rad/s] of |L| = 1.
        phase: frequencies [rad/s] of L below 0.
    """

    gain: tuple[float, ...]
    phase: tuple[float, ...]


def grid(loop: OpenLoop, points: int = POINTS) -> Vector:
    """Frequencies [rad/s] up to Nyquist's, the last, dense where the loop, open or closed, resonates."""
    nyquist = math.pi / loop.period
    rates = rates_of(loop)
    own = (np.abs(rates.imag)[:, np.newaxis] + np.abs(rates.real)[:, np.newaxis] * AROUND).ravel()
    every = np.concatenate([np.geomspace(LOWEST, 1.0, points) * nyquist, own])
    return np.unique(every[(every >= LOWEST * nyquist) & (every <= nyquist)])


def rates_of(loop: OpenLoop) -> Response:
    """The poles of a loop, open and closed, as s [1/s]."""
    poles = np.concatenate([np.linalg.eigvals(loop.a), np.linalg.eigvals(loop.closed())])
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(poles[poles != 0.0].astype(complex)) / loop.period)


def crossings(loop: OpenLoop, frequencies: Vector) -> Crossings:
    """What the response crosses between these frequencies.

    At a pole on the unit circle, as a law has at the frequency of its demand, the phase jumps: no crossing.
    """
    response = loop.transfer(frequencies)

    def one(frequency: float) -> complex:
        return complex(loop.transfer(np.array([frequency]))[0])

    gain = roots(lambda w: abs(one(w)) - 1.0, frequencies, np.abs(response) - 1.0)
    real = roots(lambda w: one(w).imag, frequencies, response.imag)
    ends = [0.0] if level(loop, response[0]) else []
    phase = sorted(w for w in (*ends, *real, float(frequencies[-1])) if -INFINITE < one(w).real < 0.0)
    return Crossings(tuple(gain), tuple(phase))


def level(loop: OpenLoop, slow: complex) -> bool:
    """Whether the response at rest is that to slow motions: nothing integrates."""
    rest = complex(loop.transfer(np.zeros(1))[0])
    return abs(rest - slow) <= LEVEL * abs(slow)


def roots(function: Callable[[float], float], places: Vector, found: Vector) -> list[float]:
    """Where a function is 0, once between each two places at which it has other signs."""
    from scipy.optimize import brentq

    first = np.flatnonzero(np.sign(found[:-1]) * np.sign(found[1:]) < 0.0)
    return [float(brentq(function, places[i], places[i + 1], rtol=1e-14)) for i in first]


def largest(function: Callable[[Vector], Vector], places: Vector) -> float:
    """The largest value of a function about some places."""
    from scipy.optimize import minimize_scalar

    found = function(places)
    i = int(found.argmax())
    ends = (float(places[max(i - 1, 0)]), float(places[min(i + 1, len(places) - 1)]))
    peak = minimize_scalar(lambda w: -function(np.array([w]))[0], bounds=ends, method="bounded")
    return max(float(found[i]), -float(peak.fun))
