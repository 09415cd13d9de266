"""Which part of a loop earns how much: family, observer and wrapper as factors of the laws' mean errors."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.law_pairs import ErrorRatio
from hydroservo.studies.trials import Rules, Trials

FACTORS = ("family", "observer", "wrapper")

Numbers = NDArray[np.float64]
Levels = Mapping[str, Mapping[str, str]]  # of each factor, by law


class CellMeans(NamedTuple):
    """The mean logarithm of the errors of the laws in one cell."""

    laws: Sequence[str]  # their names
    values: Numbers  # shape (1 + resamples, laws): the estimates, and the draws of the bootstrap


def cell_means(
    trials: Mapping[str, Mapping[str, Trials]], laws: Mapping[str, Mapping[str, str]], rules: Rules
) -> dict[str, CellMeans]:
    """The mean logarithms of the errors of the laws that lack nothing and do not lose too many runs.

    Only cells with two such laws or more have them, and none where no factor has two levels.
    """
    whole = {name for name, own in laws.items() if not own["without"]}
    found: dict[str, CellMeans] = {}
    if all(len({laws[law][factor] for law in whole}) < 2 for factor in FACTORS):
        return found
    for cell, own in trials.items():
        running = [law for law in own if law in whole and own[law].lost.mean() <= rules.most_lost]
        if len(running) > 1:
            drawn = bootstrap_weights(own[running[0]].conditions.size, rules, cell)
            found[cell] = CellMeans(
                running, np.stack([mean_draws(own[law], drawn) for law in running], axis=1)
            )
    return found


def mean_draws(trials: Trials, drawn: Numbers) -> Numbers:
    """The mean logarithm of a law's errors, and after it the draws of it."""
    return np.concatenate(([np.nanmean(trials.logs())], drawn_mean(trials, drawn)))


def drawn_mean(trials: Trials, drawn: Numbers) -> Numbers:
    """The mean logarithm of a law's errors, over draws of the conditions.

    Returns:
        A number a draw; nan where none of the drawn runs counts, and everywhere with one condition.
    """
    kept = (~trials.lost).astype(np.float64)
    with np.errstate(invalid="ignore"):
        found: Numbers = (drawn @ np.where(trials.lost, 0.0, trials.logs())) / (drawn @ kept)
    return found


def bootstrap_weights(units: int, rules: Rules, *names: str) -> Numbers:
    """How often each unit is drawn, by numbers that are functions of the seed and of names.

    There is one draw less than there are units, so that few of them spread as much as they should.

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


class FactorEffect(NamedTuple):
    """What one factor does.

    Attributes:
        share, low, high: of the variance of the logarithms of errors between laws, within cells and over all
            of them, that it explains beyond the other factors, with its interval.
        levels: the error with each of its levels over the geometric mean of those that laws have which are
            otherwise alike; median over these and over cells.
    """

    share: float
    low: float
    high: float
    levels: dict[str, ErrorRatio]


def factor_effects(
    means: Mapping[str, CellMeans], levels: Levels, confidence: float
) -> dict[str, FactorEffect]:
    """What each factor does that has more than one level.

    Shares are sums of squares of the second type: what is explained with the factor less what is explained
    without it, of sums of the factors' effects, over all that laws of a cell differ by. What they leave is
    interaction.

    Source: Yates 1934, doi:10.1080/01621459.1934.10502686, on unequal numbers in the classes.

    Fails: a factor that does nothing explains a little by luck.
    """
    used = {law for one in means.values() for law in one.laws}
    varied = [name for name in FACTORS if len({levels[law][name] for law in used}) > 1]
    found = {}
    for name in varied:
        share = draws_interval(factor_shares(means, levels, varied, name), confidence)
        own = sorted({levels[law][name] for law in used})
        ratios = {level: level_ratio(means, levels, name, level, confidence) for level in own}
        found[name] = FactorEffect(*share, levels=ratios)
    return found


def draws_interval(values: Numbers, confidence: float) -> tuple[float, float, float]:
    """An estimate and its interval, from the estimate and the draws of it after one another."""
    value, draws = float(values[0]), values[1:]
    draws = draws[~np.isnan(draws)]
    if np.isnan(value) or not draws.size:
        return value, np.nan, np.nan
    low, high = np.quantile(draws, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
    return value, float(low), float(high)


def factor_shares(
    means: Mapping[str, CellMeans], levels: Levels, varied: Sequence[str], name: str
) -> Numbers:
    """The share of one factor, with its draws."""
    explained: Numbers = np.zeros(1)
    whole: Numbers = np.zeros(1)
    others = [one for one in varied if one != name]
    for one in means.values():
        every = projection(one.laws, levels, varied)
        own = every - projection(one.laws, levels, others)
        rest = np.eye(len(one.laws)) - projection(one.laws, levels, [])
        explained = explained + np.einsum("bi,ij,bj->b", one.values, own, one.values)
        whole = whole + np.einsum("bi,ij,bj->b", one.values, rest, one.values)
    with np.errstate(invalid="ignore"):
        found: Numbers = explained / whole
    return found


def projection(laws: Sequence[str], levels: Levels, names: Sequence[str]) -> Numbers:
    """On the sums of effects of some factors: a matrix that takes the laws' values to the fitted ones."""
    columns = [np.ones(len(laws))]
    for name in names:
        own = [levels[law][name] for law in laws]
        columns += [np.array([one == level for one in own], dtype=np.float64) for level in sorted(set(own))]
    design = np.stack(columns, axis=1)
    found: Numbers = design @ np.linalg.pinv(design)
    return found


def level_ratio(
    means: Mapping[str, CellMeans], levels: Levels, name: str, level: str, confidence: float
) -> ErrorRatio:
    """The error with one level of a factor over the mean of those of laws that are otherwise alike."""
    gaps = []
    for one in means.values():
        for i, law in enumerate(one.laws):
            alike = [j for j, other in enumerate(one.laws) if is_alike_but(levels[law], levels[other], name)]
            if levels[law][name] == level and len(alike) > 1:
                gaps.append(one.values[:, i] - one.values[:, alike].mean(axis=1))
    if not gaps:
        return ErrorRatio(np.nan, np.nan, np.nan)
    value, low, high = np.exp(draws_interval(np.median(gaps, axis=0), confidence))
    return ErrorRatio(float(value), float(low), float(high))


def is_alike_but(one: Mapping[str, str], other: Mapping[str, str], name: str) -> bool:
    """Whether two laws have the same level of each factor but one."""
    return all(one[factor] == other[factor] for factor in FACTORS if factor != name)
