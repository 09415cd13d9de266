"""What a user should know of an identification, in a line each."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hydroservo.core.formatting import MINUS, quantity
from hydroservo.identification.finding import UNFIT
from hydroservo.identification.left_out import Effect
from hydroservo.identification.problem import Problem, Unknown
from hydroservo.identification.result import Estimate, LogFit
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


def remarks_of(
    problem: Problem,
    parameters: Mapping[str, Estimate],
    sure: Uncertainty,
    fits: Sequence[LogFit],
    effects: Sequence[Effect],
) -> list[str]:
    """Of each log, of each parameter, and of how well all is met."""
    late = {one.where: one for one in problem.unknowns if one.kind == "delay"}
    found = [
        f"{fit.understood.log.name}: {line}"
        for i, fit in enumerate(fits)
        for line in (*of_delay(fit, late[i]), *of_log(fit))
    ]
    if any(one.observer is not None for one in problem.experiments):
        found += [*coloured(fits), PREDICTED]
    if any(one.problem for fit in fits for one in fit.signals.values()):
        return [UNFIT, *found, *of_effects(effects), *at_ends(parameters)]
    return [*found, *of_parameters(problem, parameters, sure), *at_ends(parameters)]


def of_effects(effects: Sequence[Effect]) -> Iterator[str]:
    """What the residuals look like."""
    if not effects:
        yield "what is left looks like none of the effects tried"
        return
    alike = [one.name for one in effects if one.alike]
    also = f"; {some_of(alike)} cannot be told apart from it" if alike else ""
    yield f"what is left looks most like {effects[0]}{also}"


def some_of(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def coloured(fits: Sequence[LogFit]) -> Iterator[str]:
    """Of which signals more than noise is left in predictions."""
    for fit in fits:
        for name, one in fit.signals.items():
            if one.whiteness < COLOURED and abs(one.correlation) > HANGING and 1.0 - one.explained > EXACT:
                yield (
                    f"{fit.understood.log.name}: {name}: what is left is not white noise (correlation "
                    f"{one.correlation:.2f} of neighbouring samples): the model misses something"
                )


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
        if one.problem:
            yield f"the model does not fit {name}: {one.problem}"
        if one.held_out > WORSE * one.held_in and 1.0 - one.explained > EXACT:
            missed, met = plain(one.held_out, one.unit), plain(one.held_in, one.unit)
            yield f"{name}: the last fifth, held out, is missed by {missed} rms, and what was fitted by {met}"


def of_parameters(problem: Problem, parameters: Mapping[str, Estimate], sure: Uncertainty) -> Iterator[str]:
    """Which parameters the logs do not tell and why, and which of them tell less than they seem to."""
    for i, (path, one) in enumerate(parameters.items()):
        if not one.identifiable and not one.at_end:
            yield f"{path}: {reason(problem, sure, i)}"
        elif one.identifiable and one.resampled > WIDER:
            times = f"{one.resampled:.1f} times as wide"
            yield f"{path}: over resampled stretches of the logs its interval is {times}"


def at_ends(parameters: Mapping[str, Estimate]) -> Iterator[str]:
    """Which parameters lie at an end of their range."""
    for path, one in parameters.items():
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
