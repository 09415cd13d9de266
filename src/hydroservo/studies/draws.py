"""Bootstrap of a law's mean over searches and conditions, the same numbers whatever else is compared."""

from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.rules import Rules
from hydroservo.studies.trials import Trials

__all__ = ["drawn_mean", "weights"]

Numbers = NDArray[np.float64]


def drawn_mean(trials: Trials, of_searches: Numbers, of_conditions: Numbers) -> Numbers:
    """The mean logarithm of a law's errors, over draws of its searches and of the conditions.

    Args:
        trials: the law's test runs; lost ones do not count.
        of_searches: how often each is drawn, of shape (resamples, searches): :func:`weights` by cell and law.
        of_conditions: likewise, the same for all laws of a cell: :func:`weights` by cell.

    Returns:
        A number a draw; nan where none of the drawn runs counts, and everywhere with one search or one
        condition.
    """
    kept = (~trials.lost).astype(np.float64)
    with np.errstate(invalid="ignore"):
        each = (of_searches @ np.where(trials.lost, 0.0, trials.logs())) / (of_searches @ kept)
        if trials.lost.any() or len(kept) < 2:
            of_conditions = np.where(np.isnan(each), 0.0, of_conditions)
            each = np.nan_to_num(each)
        found: Numbers = np.einsum("bc,bc->b", of_conditions, each) / of_conditions.sum(axis=1)
    return found


def weights(units: int, rules: Rules, *names: str) -> Numbers:
    """How often each unit is drawn, by numbers that are functions of the seed and of names.

    There is one draw less than there are units, so that few of them spread as much as they should.

    Args:
        units: how many there are.
        rules: how many times they are drawn, and the seed.
        names: of what they are units of.

    Returns:
        Shape (resamples, units); nan of a single unit.

    Source: Rao and Wu 1988, doi:10.1080/01621459.1988.10478591, with samples of n - 1; Philox4x64-10, Salmon,
    Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405.
    """
    if units < 2:
        return np.full((rules.resamples, units), np.nan)
    stream = int.from_bytes(sha256("\0".join(names).encode()).digest()[:8], "little")
    generator = np.random.Philox(key=np.array([rules.seed, stream], dtype=np.uint64))
    bits = generator.random_raw(rules.resamples * (units - 1)).reshape(rules.resamples, units - 1)
    drawn = np.ldexp((bits >> np.uint64(11)).astype(np.float64), -53) * units
    places = drawn.astype(np.int64) + units * np.arange(rules.resamples)[:, None]
    counts = np.bincount(places.ravel(), minlength=rules.resamples * units)
    return counts.reshape(rules.resamples, units).astype(np.float64)
