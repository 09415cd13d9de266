"""A law's error and the least that any command can leave, over sample periods."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Annotated, NamedTuple

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.control.monitors.tracking_error import TrackingErrorValues
from hydroservo.core.assumptions import margin_ratio
from hydroservo.core.block import replace
from hydroservo.core.errors import HydroservoError, ParameterError, require
from hydroservo.core.field import Field, declared_fields
from hydroservo.limits.command import command_limits
from hydroservo.limits.finding import over_periods_finding
from hydroservo.limits.least_error import (
    WORSE,
    MachineLimits,
    limit,
    machine_limits,
    machine_limits_of,
    without_law,
)
from hydroservo.runs.arguments import as_list, checked_loop
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.run import RunProgress
from hydroservo.runs.step_sizes import at_period
from hydroservo.show import Finding
from hydroservo.show.html import html_of
from hydroservo.work.notebook_bar import shows_progress


class LimitsAtPeriod(NamedTuple):
    """The rms errors at one sample period; nan where missing."""

    period: Annotated[float, Field("s", "sample period")]
    law: Annotated[float, Field("y", "what the law leaves")]
    causal: Annotated[float, Field("y", "the causal limit")]
    clairvoyant: Annotated[float, Field("y", "the clairvoyant limit")]
    reason: str = ""  # why one is missing; empty where none is
    warnings: Sequence[str] = ()  # of the law's run

    def multiples(self) -> dict[str, float]:
        """How many times each limit the law leaves; inf over a limit of 0, nan for 0 over 0."""
        best = {"causal": self.causal, "clairvoyant": self.clairvoyant}
        return {name: margin_ratio(self.law, error) for name, error in best.items()}


class LimitsOverPeriods(NamedTuple):
    """A law's error and its limits over sample periods.

    Attributes:
        at: the errors at each period, from the shortest on.
        loop: the loop, with a period of its own.
    """

    at: Sequence[LimitsAtPeriod]
    loop: Loop

    @property
    def error(self) -> Field:
        """The declaration of the errors."""
        return declared_fields(TrackingErrorValues)["rms_error"].of(self.loop.controls.declared())

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return over_periods_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())


@shows_progress
def limit_over_periods(
    loop: Loop,
    periods: Sequence[float] | Mapping[float, Mapping[str, float]],
    *,
    progress: RunProgress | None = None,
) -> LimitsOverPeriods:
    """What a law leaves, and the least that any command can leave, at several sample periods::

        limit_over_periods(loop, [1e-3, 2e-3, 4e-3])
        limit_over_periods(loop, {1e-3: {"controller.proportional_gain": 3.0}, 4e-3: slow.parameters})

    At each period it is what :func:`~hydroservo.limit` finds. A computing delay keeps its share of the
    period, and the integrator's steps are at most as long as they were. Where the law cannot run or diverges,
    or a search for a limit does not end, that error is missing, and the reason is there.

    Args:
        loop: the loop, as for :func:`~hydroservo.limit`.
        periods: the sample periods [s], each once, at most as long as the run; or for each the numbers that
            the loop has there, in SI units by path, such as those that ``tune`` found. A list leaves the law
            its gains.
        progress: called now and then with the fraction done.

    Raises:
        ParameterError: a period out of range.
        HydroservoError: CasADi is not installed, or no period has a law's error or a limit; the reason is
            that of the shortest.

    Source: as :func:`~hydroservo.limit`.
    Fails for a law whose numbers are those of one sample period, such as StateSpace: it runs at the others
    all the same, as another law.
    """
    report = progress or (lambda _: None)
    require("casadi", "limit", "a limit")
    loop = checked_loop(loop)
    gains: Mapping[float, Mapping[str, float]] = periods if isinstance(periods, Mapping) else {}
    wanted = checked_periods([*gains] if isinstance(periods, Mapping) else periods, loop.simulation.duration)
    loops = [replace(at_period(loop, period), gains.get(period, {})) for period in wanted]

    def report_from(start: int, done: float) -> None:
        report((start + done) / len(loops))

    found = [limits_at(there, partial(report_from, i)) for i, there in enumerate(loops)]
    report(1.0)
    if all(math.isnan(one.clairvoyant) and math.isnan(one.law) for one in found):
        raise HydroservoError(found[0].reason)
    return LimitsOverPeriods(found, loop)


def checked_periods(periods: Sequence[float], duration: float) -> list[float]:
    """Sample periods that a run can have [s], from the shortest on."""
    values = as_list("periods", periods, "numbers [s]")
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            raise ParameterError("periods", value, "must be numbers [s]")
        said = f"{value:g} s"
        if not 0.0 < value < math.inf:
            raise ParameterError("periods", said, "must be above 0")
        if value > duration:
            raise ParameterError("periods", said, f"must be at most the duration, {duration:g} s")
        if values.count(value) > 1:
            raise ParameterError("periods", said, "is there twice")
    if not values:
        raise ParameterError("periods", values, "must be at least one number [s]")
    return sorted(map(float, values))


def limits_at(loop: Loop, report: RunProgress) -> LimitsAtPeriod:
    """The errors at a loop's own period.

    A search that does not end where the law's run begins it, as where that is unstable, begins at rest.
    """
    period, lines = loop.simulation.period, []
    law, best, reason = math.nan, MachineLimits(math.nan, math.nan, False), ""
    try:
        found = limit(loop, progress=report)
    except HydroservoError as error:
        reason = str(error)
    else:
        diverged = bool(found.law["diverged"])
        law, reason = float(found.law["rms_error"]), "the law's run diverges" if diverged else ""
        best, lines = machine_limits_of(found.causal, found.clairvoyant), warnings_of(found.law)
    if not best.converged:
        with suppress(HydroservoError):  # it is not the law that is in the way
            best = machine_limits(without_law(loop), command_limits(loop))
    if not best.converged or best.clairvoyant > law * (1.0 + WORSE):
        best = MachineLimits(math.nan, math.nan, False)
        reason = reason or "the search for a limit does not end"
    return LimitsAtPeriod(period, law, best.causal, best.clairvoyant, reason, lines)
