"""The mean logarithm of each law's errors in a cell, with the bootstrap's draws of it."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.rules import Rules
from hydroservo.studies.trials import Trials

FACTORS = ("family", "observer", "wrapper")

Numbers = NDArray[np.float64]


class Means(NamedTuple):
    """The mean logarithm of the errors of the laws in one cell.

    Attributes:
        laws: their names.
        values: shape (1 + resamples, laws): the estimates, and the draws of the bootstrap.
    """

    laws: Sequence[str]
    values: Numbers


def means_of(
    trials: Mapping[str, Mapping[str, Trials]], laws: Mapping[str, Mapping[str, str]], rules: Rules
) -> dict[str, Means]:
    """The mean logarithms of the errors of the laws that lack nothing and do not lose too many runs.

    Args:
        trials: the test runs, by cell and law.
        laws: their factors and what they are ``without``.
        rules: of the comparison.

    Returns:
        Those of each cell that has two such laws or more; of none where no factor has two levels.
    """
    whole = {name for name, own in laws.items() if not own["without"]}
    found: dict[str, Means] = {}
    if all(len({laws[law][factor] for law in whole}) < 2 for factor in FACTORS):
        return found
    for cell, own in trials.items():
        running = [law for law in own if law in whole and own[law].lost.mean() <= rules.most_lost]
        if len(running) > 1:
            drawn = weights(own[running[0]].conditions.size, rules, cell)
            found[cell] = Means(running, np.stack([values_of(own[law], drawn) for law in running], axis=1))
    return found


def values_of(trials: Trials, drawn: Numbers) -> Numbers:
    """The mean logarithm of a law's errors, and after it the draws of it."""
    return np.concatenate(([np.nanmean(trials.logs())], drawn_mean(trials, drawn)))


def drawn_mean(trials: Trials, drawn: Numbers) -> Numbers:
    """The mean logarithm of a law's errors, over draws of the conditions.

    Args:
        trials: the law's test runs; lost ones do not count.
        drawn: how often each condition is drawn, of shape (resamples, conditions): :func:`weights`.

    Returns:
        A number a draw; nan where none of the drawn runs counts, and everywhere with one condition.
    """
    kept = (~trials.lost).astype(np.float64)
    with np.errstate(invalid="ignore"):
        found: Numbers = (drawn @ np.where(trials.lost, 0.0, trials.logs())) / (drawn @ kept)
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
