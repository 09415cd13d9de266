"""What a user should know of an identification, and whether a larger model earns its numbers."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import enumeration, number, plain_quantity
from hydroservo.identification.effects import LeftOutEffect
from hydroservo.identification.finding import UNFIT
from hydroservo.identification.problem import Problem, UnknownNumber
from hydroservo.identification.regression import long_run_covariance
from hydroservo.identification.result import Estimate, Identified, LogFit
from hydroservo.identification.segments import TO_DEVIATION
from hydroservo.identification.uncertainty import Uncertainty

NOTHING = 12.0  # information, in units of a range, that is no more than the range itself says
TOGETHER = 0.9  # correlation from which on two numbers are told together alone
SURE = 3.0  # deviations, from which on an offset or a delay is one
COLOURED = 1e-3  # probability that residuals of a prediction are white, below which they are not
HANGING = 0.1  # correlation of such a residual with the next from which on that matters
EXACT = 1e-12  # share of a signal's variance, below which what is left is of rounding
PREDICTED = (
    "numbers are of predictions: their intervals know nothing of the bias that noise leaves in these, the "
    "more the shorter the horizon"
)
END = 0.1  # of a sample, within which a delay lies at an end of its range
WORSE = 1.5  # times what is fitted, that what is held out may be missed by
WIDER = 1.5  # times, that resampled intervals may be wider
STRONG = 10.0  # by which a criterion must be less for a larger model to have earned its numbers
CUT = 4.0  # robust deviations, to which residuals are cut

Samples = NDArray[np.float64]


def remarks_of(
    problem: Problem,
    parameters: Mapping[str, Estimate],
    sure: Uncertainty,
    fits: Sequence[LogFit],
    effects: Sequence[LeftOutEffect],
) -> list[str]:
    """Of each log, of each parameter, and of how well all is met."""
    late = {one.where: one for one in problem.unknowns if one.kind == "delay"}
    found = [
        f"{fit.understood.log.name}: {line}"
        for i, fit in enumerate(fits)
        for line in (*delay_remarks(fit, late[i]), *log_remarks(fit))
    ]
    if any(one.observer is not None for one in problem.experiments):
        found += [*coloured_remarks(fits), PREDICTED]
    if any(one.problem for fit in fits for one in fit.signals.values()):
        return [UNFIT, *found, *effect_remarks(effects), *end_remarks(parameters)]
    return [*found, *parameter_remarks(problem, parameters, sure), *end_remarks(parameters)]


def effect_remarks(effects: Sequence[LeftOutEffect]) -> Iterator[str]:
    """What the residuals look like."""
    if not effects:
        yield "what is left looks like none of the effects tried"
        return
    alike = [one.name for one in effects if one.alike]
    also = f"; {enumeration(alike)} cannot be told apart from it" if alike else ""
    yield f"what is left looks most like {effects[0]}{also}"


def coloured_remarks(fits: Sequence[LogFit]) -> Iterator[str]:
    """Of which signals more than noise is left in predictions."""
    for fit in fits:
        for name, one in fit.signals.items():
            if one.whiteness < COLOURED and abs(one.correlation) > HANGING and 1.0 - one.explained > EXACT:
                yield (
                    f"{fit.understood.log.name}: {name}: what is left is not white noise (correlation "
                    f"{one.correlation:.2f} of neighbouring samples): the model misses something"
                )


def delay_remarks(fit: LogFit, unknown: UnknownNumber) -> Iterator[str]:
    """Whether the delay of a log lies at an end of what is sought."""
    low, high = unknown.low * unknown.scale, unknown.high * unknown.scale
    near = END * fit.understood.segments[0].period
    if not low + near < fit.delay[0] < high - near:
        ends = f"{plain_quantity(low, 's')} to {plain_quantity(high, 's')}"
        yield f"its delay lies at an end of what is sought, {ends}; a wider range of delay may fit better"


def log_remarks(fit: LogFit) -> Iterator[str]:
    """What was found in a log, and what the model misses of it."""
    yield from fit.understood.remarks
    delay, unsure = fit.delay
    if abs(delay) > SURE * unsure:
        way = "later" if delay > 0.0 else "earlier"
        shift = plain_quantity(abs(delay), "s")
        yield f"what is measured comes {shift} {way} than of the model; that is taken out"
    for name, one in fit.signals.items():
        offset, unsure = one.offset
        if abs(offset) > SURE * unsure:
            yield f"{name} reads {plain_quantity(offset, one.unit)} more than its model; that is taken out"
        if one.problem:
            yield f"the model does not fit {name}: {one.problem}"
        if one.held_out > WORSE * one.held_in and 1.0 - one.explained > EXACT:
            missed, met = plain_quantity(one.held_out, one.unit), plain_quantity(one.held_in, one.unit)
            yield f"{name}: the last fifth, held out, is missed by {missed} rms, and what was fitted by {met}"


def parameter_remarks(
    problem: Problem, parameters: Mapping[str, Estimate], sure: Uncertainty
) -> Iterator[str]:
    """Which parameters the logs do not tell and why, and which of them tell less than they seem to."""
    for i, (path, one) in enumerate(parameters.items()):
        if not one.identifiable and not one.at_end:
            yield f"{path}: {untold_reason(problem, sure, i)}"
        elif one.identifiable and one.resampled > WIDER:
            times = f"{one.resampled:.1f} times as wide"
            yield f"{path}: over resampled stretches of the logs its interval is {times}"


def end_remarks(parameters: Mapping[str, Estimate]) -> Iterator[str]:
    """Which parameters lie at an end of their range."""
    for path, one in parameters.items():
        if one.at_end:
            end = plain_quantity(one.value, one.unit)
            yield f"{path}: ends at {end}, an end of its range; a wider one may fit better"


def untold_reason(problem: Problem, sure: Uncertainty, i: int) -> str:
    """Why the logs do not tell a parameter."""
    if sure.information[i, i] < NOTHING:
        return "has hardly any influence on what was measured: the logs cannot tell it"
    others = np.abs(sure.correlations[i]).copy()
    others[i] = 0.0
    j = int(others.argmax())
    if others[j] > TOGETHER:
        name = problem.unknowns[j].name
        return f"the logs cannot tell it apart from {name} (correlation {sure.correlations[i, j]:.2f})"
    return "the logs do not tell it well enough: its interval means little"


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
    check_comparable(larger, smaller, numbers)
    gained, independent, held = 0.0, 0.0, {}
    for one, beside in zip(larger.logs, smaller.logs, strict=True):
        for name, own, others in residual_pairs(one, beside):
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


def check_comparable(larger: Identified, smaller: Identified, numbers: int) -> None:
    """Refuse what cannot be compared."""
    if [one.understood.log.name for one in larger.logs] != [one.understood.log.name for one in smaller.logs]:
        raise ParameterError("other", smaller.scenario, "must be fitted to the same logs")
    for one, other in zip(larger.logs, smaller.logs, strict=True):
        for name in ("time", *one.signals):
            if name in other.data and np.array_equal(one.data[name], other.data[name], equal_nan=True):
                continue
            problem = f"must be fitted to the same {one.understood.log.name}"
            raise ParameterError("other", smaller.scenario, problem)
    if larger.horizon != smaller.horizon:
        raise ParameterError("other", smaller.scenario, "must be fitted with the same horizon")
    if not numbers:
        count = len(larger.parameters)
        problem = f"has {count} numbers that are sought, as many as {larger.scenario}; one must have more"
        raise ParameterError("other", smaller.scenario, problem)


def residual_pairs(one: LogFit, other: LogFit) -> Iterator[tuple[str, Samples, Samples]]:
    """Of each signal the residuals of both models, where it was measured; outliers cut by the first's."""
    for name in one.signals:
        apart = [(fit.data[name] - fit.data[f"{name}_simulated"]).values for fit in (one, other)]
        there = np.isfinite(apart[0]) & np.isfinite(apart[1])
        own, others = (values[there] for values in apart)
        yield name, cut_outliers(own), cut_outliers(others)


def cut_outliers(values: Samples) -> Samples:
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
