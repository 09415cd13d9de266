"""Commands that may tell much of a machine: multisines, chirps and steps."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.formatting import number

TONES = 12
EACH = 8  # candidates of each kind
HIGHEST = 100.0  # Hz
SHARE = 0.1  # of the sampling frequency, which no tone exceeds
WIDEST = 4.0  # octaves above the lowest frequency that a band reaches at least, where it may

Samples = NDArray[np.float64]


class Candidate(NamedTuple):
    """A command before it has a size.

    Attributes:
        name: what it is, for people.
        values: at each sample, largest size 1, mean 0.
    """

    name: str
    values: Samples


def candidates(samples: int, period: float, seed: int) -> list[Candidate]:
    """Commands of so many samples, as many of each kind.

    Args:
        samples: of each.
        period: between them [s].
        seed: of their bands, levels and phases.

    Source: Pintelon, Schoukens, System Identification, 2012, ch. 5 (multisines and chirps); Ljung, System
    Identification, 1999, sec. 13.3 (steps at random).
    Fails to hold the best command there is.
    """
    rng = np.random.default_rng(seed)
    time = period * np.arange(samples)
    kinds: tuple[Callable[..., Candidate], ...] = (multisine, chirp, steps)
    return [kind(time, rng) for _ in range(EACH) for kind in kinds]


def multisine(time: Samples, rng: np.random.Generator) -> Candidate:
    """Tones of one size and random phase, evenly over octaves."""
    low, high = band(time, rng)
    tones = np.geomspace(low, high, TONES)
    phases = rng.uniform(0.0, 2.0 * np.pi, TONES)
    name = f"multisine of {TONES} tones from {number(low)} to {number(high)} Hz"
    return evened(name, np.sin(2.0 * np.pi * np.outer(time, tones) + phases).sum(axis=1))


def chirp(time: Samples, rng: np.random.Generator) -> Candidate:
    """A tone whose frequency grows by as many octaves each second."""
    low, high = band(time, rng)
    growth = np.log(high / low) / time[-1]
    angle = 2.0 * np.pi * low * np.expm1(growth * time) / growth
    return evened(f"chirp from {number(low)} to {number(high)} Hz", np.sin(angle))


def steps(time: Samples, rng: np.random.Generator) -> Candidate:
    """Levels at random, each held for one to three times as long as the shortest."""
    low, high = band(time, rng)
    shortest = 0.25 / np.sqrt(low * high)
    jumps = np.cumsum(rng.uniform(1.0, 3.0, int(time[-1] / shortest) + 2)) * shortest
    levels = rng.uniform(-1.0, 1.0, jumps.size + 1)
    name = f"steps at random, {number(shortest)} to {number(3.0 * shortest)} s long"
    return evened(name, levels[np.searchsorted(jumps, time, side="right")])


def band(time: Samples, rng: np.random.Generator) -> tuple[float, float]:
    """The lowest and the highest frequency of a command [Hz]."""
    least = 2.0 / time[-1]
    most = max(min(HIGHEST, SHARE * (time.size - 1) / time[-1]), 2.0 * least)
    low = float(np.exp(rng.uniform(np.log(least), np.log(np.sqrt(least * most)))))
    return low, float(np.exp(rng.uniform(np.log(min(WIDEST * low, most)), np.log(most))))


def evened(name: str, values: Samples) -> Candidate:
    """A command of mean 0 and largest size 1."""
    even = values - values.mean()
    return Candidate(name, even / max(float(np.abs(even).max()), 1e-300))


def rolled(candidate: Candidate, share: float) -> Candidate:
    """The same command begun elsewhere in it, so that what it moves has room.

    What a command moves lies about where its sum does: it begins where that has so large a share of its
    travel below it.

    Args:
        candidate: of mean 0, so that it ends where it began.
        share: of the way that lies below the start, 0 to 1.
    """
    travel = np.cumsum(candidate.values)
    least, most = float(travel.min()), float(travel.max())
    first = int(np.abs(travel - (least + min(max(share, 0.0), 1.0) * (most - least))).argmin())
    return candidate._replace(values=np.roll(candidate.values, -first - 1))
