"""Which part of a loop earns how much: family, observer and wrapper as factors."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.ablation import Ratio
from hydroservo.studies.means import FACTORS, Means

Numbers = NDArray[np.float64]
Levels = Mapping[str, Mapping[str, str]]  # of each factor, by law


class Effect(NamedTuple):
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
    levels: dict[str, Ratio]


def effects(means: Mapping[str, Means], levels: Levels, confidence: float) -> dict[str, Effect]:
    """What each factor does that has more than one level.

    Shares are sums of squares of the second type: what is explained with the factor less what is explained
    without it, of sums of the factors' effects, over all that laws of a cell differ by. What they leave is
    interaction.

    Args:
        means: of each cell.
        levels: of each law, by factor.
        confidence: of the intervals: percentiles of the bootstrap.

    Source: Yates 1934, doi:10.1080/01621459.1934.10502686, on unequal numbers in the classes.

    Fails: a factor that does nothing explains a little by luck.
    """
    used = {law for one in means.values() for law in one.laws}
    varied = [name for name in FACTORS if len({levels[law][name] for law in used}) > 1]
    found = {}
    for name in varied:
        share = interval_of(shares(means, levels, varied, name), confidence)
        own = sorted({levels[law][name] for law in used})
        ratios = {level: of_level(means, levels, name, level, confidence) for level in own}
        found[name] = Effect(*share, levels=ratios)
    return found


def interval_of(values: Numbers, confidence: float) -> tuple[float, float, float]:
    """An estimate and its interval, from the estimate and the draws of it after one another."""
    value, draws = float(values[0]), values[1:]
    draws = draws[~np.isnan(draws)]
    if np.isnan(value) or not draws.size:
        return value, np.nan, np.nan
    low, high = np.quantile(draws, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
    return value, float(low), float(high)


def shares(means: Mapping[str, Means], levels: Levels, varied: Sequence[str], name: str) -> Numbers:
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


def of_level(means: Mapping[str, Means], levels: Levels, name: str, level: str, confidence: float) -> Ratio:
    """The error with one level of a factor over the mean of those of laws that are otherwise alike."""
    gaps = []
    for one in means.values():
        for i, law in enumerate(one.laws):
            alike = [j for j, other in enumerate(one.laws) if same_but(levels[law], levels[other], name)]
            if levels[law][name] == level and len(alike) > 1:
                gaps.append(one.values[:, i] - one.values[:, alike].mean(axis=1))
    if not gaps:
        return Ratio(np.nan, np.nan, np.nan)
    value, low, high = np.exp(interval_of(np.median(gaps, axis=0), confidence))
    return Ratio(float(value), float(low), float(high))


def same_but(one: Mapping[str, str], other: Mapping[str, str], name: str) -> bool:
    """Whether two laws have the same level of each factor but one."""
    return all(one[factor] == other[factor] for factor in FACTORS if factor != name)
