"""What a user should know of an identification, in a line each."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hydroservo.formatting import MINUS, quantity
from hydroservo.identification.problem import Problem, Unknown
from hydroservo.identification.result import Estimate, LogFit, SignalFit
from hydroservo.identification.uncertainty import Uncertainty

__all__ = ["remarks_of"]

NOTHING = 12.0  # information, in units of a range, that is no more than the range itself says
TOGETHER = 0.9  # correlation from which on two numbers are told together alone
SURE = 3.0  # deviations, from which on an offset or a delay is one
COLOURED = 1e-3  # probability that residuals are white, below which they are not
HANGING = 0.1  # correlation of a residual with the next from which on that matters
EXACT = 1e-12  # share of a signal's variance, below which what is left is of rounding
LITTLE = 0.5  # share of a signal's variance, below which the model is of something else
PREDICTED = (
    "numbers are of predictions: their intervals know nothing of the bias that noise leaves in these, the "
    "more the shorter the horizon"
)
END = 0.1  # of a sample, within which a delay lies at an end of its range
WORSE = 1.5  # times what is fitted, that what is held out may be missed by
WIDER = 1.5  # times, that resampled intervals may be wider


def remarks_of(
    problem: Problem,
    parameters: Mapping[str, Estimate],
    sure: Uncertainty,
    fits: Sequence[LogFit],
) -> list[str]:
    """Of each log, of each parameter, and of how well all is met."""
    late = {one.where: one for one in problem.unknowns if one.kind == "delay"}
    found = [
        f"{fit.understood.log.name}: {line}"
        for i, fit in enumerate(fits)
        for line in (*of_delay(fit, late[i]), *of_log(fit))
    ]
    predicted = any(one.observer is not None for one in problem.experiments)
    return [*found, *([PREDICTED] if predicted else []), *of_parameters(problem, parameters, sure)]


def of_delay(fit: LogFit, unknown: Unknown) -> Iterator[str]:
    """Whether the delay of a log lies at an end of what is sought."""
    low, high = unknown.low * unknown.scale, unknown.high * unknown.scale
    near = END * fit.understood.segments[0].period
    if not low + near < fit.delay[0] < high - near:
        ends = f"{plain(low, 's')} to {plain(high, 's')}"
        yield f"its delay lies at an end of what is sought, {ends}; a wider range of delay may fit better"


def of_log(fit: LogFit) -> Iterator[str]:
    """What was found in a log, and what the model misses of it."""
    yield from fit.understood.remarks
    delay, unsure = fit.delay
    if abs(delay) > SURE * unsure:
        way = "later" if delay > 0.0 else "earlier"
        yield f"what is measured comes {plain(abs(delay), 's')} {way} than of the model; that is taken out"
    for name, one in fit.signals.items():
        offset, unsure = one.offset
        if abs(offset) > SURE * unsure:
            yield f"{name} reads {plain(offset, one.unit)} more than its model; that is taken out"
        if 1.0 - one.explained < EXACT:
            continue
        if one.whiteness < COLOURED and abs(one.correlation) > HANGING:
            yield f"{name}: {missed_of(one)}"
        if one.held_out > WORSE * one.held_in:
            missed, met = plain(one.held_out, one.unit), plain(one.held_in, one.unit)
            yield f"{name}: the last fifth, held out, is missed by {missed} rms, and what was fitted by {met}"


def missed_of(one: SignalFit) -> str:
    """What is said of a signal of which more than noise is left."""
    if one.explained < LITTLE:
        explained = f"{100.0 * one.explained:.0f} %" if one.explained > 0.0 else "none"
        return (
            f"the machine found does not do this: it explains {explained} of the variance; are unit, sign "
            "and column right? Until then intervals mean little"
        )
    return (
        f"what is left of it is no white noise (correlation {one.correlation:.2f} from one sample to the "
        "next): the model misses something"
    )


def of_parameters(problem: Problem, parameters: Mapping[str, Estimate], sure: Uncertainty) -> Iterator[str]:
    """Which parameters the logs do not tell and why, and which lie at an end of their range."""
    for i, (path, one) in enumerate(parameters.items()):
        if not one.identifiable:
            yield f"{path}: {reason(problem, sure, i)}"
        elif one.resampled > WIDER:
            times = f"{one.resampled:.1f} times as wide"
            yield f"{path}: over resampled stretches of the logs its interval is {times}"
        if one.at_end:
            end = plain(one.value, one.unit)
            yield f"{path}: ends at {end}, an end of its range; a wider one may fit better"


def reason(problem: Problem, sure: Uncertainty, i: int) -> str:
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


def plain(value: float, unit: str) -> str:
    """A quantity in characters that every terminal has."""
    return quantity(value, unit).replace(MINUS, "-")
