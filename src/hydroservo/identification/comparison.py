"""Whether a larger model earns its numbers: two scenarios fitted to the same logs."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import number
from hydroservo.identification.regression import long_run_covariance
from hydroservo.identification.result import Identified, LogFit
from hydroservo.identification.segments import TO_DEVIATION

STRONG = 10.0  # by which a criterion must be less for a larger model to have earned its numbers
CUT = 4.0  # robust deviations, to which residuals are cut

Samples = NDArray[np.float64]


class Comparison(NamedTuple):
    """Two models of the same logs; the larger one has more numbers that were sought.

    Attributes:
        larger: its scenario.
        smaller: that of the other.
        numbers: how many more numbers the larger one has.
        held_out: of each log and signal, rms errors over the last fifth of the larger and of the smaller.
        held_out_ratio: geometric mean of the first over the second.
        independent: samples of all signals that count as independent.
        criterion: by how much the information criterion of the larger is less.
        earns: whether the larger one earns its numbers.
    """

    larger: str
    smaller: str
    numbers: int
    held_out: Mapping[tuple[str, str], tuple[float, float]]
    held_out_ratio: float
    independent: float
    criterion: float
    earns: bool

    @property
    def verdict(self) -> str:
        """Whether the larger one earns its numbers, in words."""
        says = "earns" if self.earns else "does not earn"
        more = f"its {self.numbers} more numbers" if self.numbers > 1 else "its one more number"
        return f"{self.larger} {says} {more} over {self.smaller}"

    def __str__(self) -> str:
        way = "less" if self.criterion > 0.0 else "more"
        return (
            f"{self.verdict}: what is held out is missed by "
            f"{number(self.held_out_ratio)} times as much, and the information criterion is "
            f"{number(abs(self.criterion))} {way}, with {number(self.independent)} independent samples "
            f"(more than {STRONG:g} less, and no larger error, is asked)"
        )


def compare(found: Identified, other: Identified) -> Comparison:
    """Whether the larger of two models of the same logs earns its numbers.

    It does if it foretells what was held out no worse, and if Schwarz's criterion is less by more than 10::

        BIC = sum over signals of n_j ln(mean r_j^2) + k ln(sum of n_j)

    with the k numbers that were sought, and n_j the independent samples of a signal: its samples times the
    variance of the larger model's residuals over what that of their mean is times the samples, for residuals
    that hang together tell less than there are of them.

    Args:
        found: one model.
        other: the other, from the same logs.

    Raises:
        ParameterError: the logs differ, or both have as many numbers.

    Source: Schwarz, Annals of Statistics 6, 1978, doi:10.1214/aos/1176344136; Kass, Raftery, J. American
    Statistical Association 90, 1995, doi:10.1080/01621459.1995.10476572 (10 as very strong evidence).
    Fails where both models miss the same: the better of two wrong ones may win.
    """
    larger, smaller = (found, other) if len(found.parameters) >= len(other.parameters) else (other, found)
    numbers = len(larger.parameters) - len(smaller.parameters)
    check(larger, smaller, numbers)
    gained, independent, held = 0.0, 0.0, {}
    for one, beside in zip(larger.logs, smaller.logs, strict=True):
        for name, own, others in residuals(one, beside):
            samples = independent_samples(own)
            gained += samples * math.log(mean_square(others) / mean_square(own))
            independent += samples
            key = one.understood.log.name, name
            held[key] = one.signals[name].held_out, beside.signals[name].held_out
            if not all(error > 0.0 for error in held[key]):
                problem = (
                    f"leaves no error of {name} in what is held out, by which models could be told apart"
                )
                raise ParameterError("other", smaller.scenario, problem)
    ratio = math.exp(float(np.mean([math.log(mine / others) for mine, others in held.values()])))
    criterion = gained - numbers * math.log(independent)
    earns = criterion > STRONG and ratio <= 1.0
    return Comparison(larger.scenario, smaller.scenario, numbers, held, ratio, independent, criterion, earns)


def check(larger: Identified, smaller: Identified, numbers: int) -> None:
    """Refuse what cannot be compared."""
    if [one.understood.log.name for one in larger.logs] != [one.understood.log.name for one in smaller.logs]:
        raise ParameterError("other", smaller.scenario, "must be fitted to the same logs")
    for one, other in zip(larger.logs, smaller.logs, strict=True):
        if not all(name in other.data and same(one, other, name) for name in ("time", *one.signals)):
            raise ParameterError(
                "other", smaller.scenario, f"must be fitted to the same {one.understood.log.name}"
            )
    if larger.horizon != smaller.horizon:
        raise ParameterError("other", smaller.scenario, "must be fitted with the same horizon")
    if not numbers:
        count = len(larger.parameters)
        problem = f"has {count} numbers that are sought, as many as {larger.scenario}; one must have more"
        raise ParameterError("other", smaller.scenario, problem)


def same(one: LogFit, other: LogFit, name: str) -> bool:
    """Whether a signal was measured alike."""
    return np.array_equal(one.data[name].values, other.data[name].values, equal_nan=True)


def residuals(one: LogFit, other: LogFit) -> Iterator[tuple[str, Samples, Samples]]:
    """Of each signal the residuals of both models, where it was measured; outliers cut by the first's."""
    for name in one.signals:
        apart = [(fit.data[name] - fit.data[f"{name}_simulated"]).values for fit in (one, other)]
        there = np.isfinite(apart[0]) & np.isfinite(apart[1])
        own, others = (values[there] for values in apart)
        yield name, cut(own), cut(others)


def cut(values: Samples) -> Samples:
    """Residuals of which none is more than four robust deviations."""
    limit = CUT * TO_DEVIATION * float(np.median(np.abs(values)))
    return np.clip(values, -limit, limit)


def mean_square(values: Samples) -> float:
    return max(float(np.mean(values**2)), 1e-300)


def independent_samples(values: Samples) -> float:
    """How many independent samples have a mean as sure as that of these residuals."""
    even = values - values.mean()
    total = float(even @ even)
    spread = float(long_run_covariance([even[:, np.newaxis]])[0, 0])
    return values.size * min(total / spread, 1.0) if spread > 0.0 else float(values.size)
