"""What an identification found."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.formatting import MINUS, NONE, column, number, quantity
from hydroservo.html_tables import Strong, html_heading, html_remarks, html_table
from hydroservo.identification.fitted import Fitted
from hydroservo.identification.left_out import Effect
from hydroservo.identification.on_base import on_base
from hydroservo.identification.segments import Understood
from hydroservo.loop import Loop

if TYPE_CHECKING:
    import xarray as xr

UNFIT = "THE MODEL DOES NOT FIT the logs, so they tell none of its numbers."


class Estimate(NamedTuple):
    """A number that was sought, in SI units.

    Attributes:
        value: the best one.
        low: lower end of its 95 % interval, inside its range.
        high: the upper end.
        identifiable: whether the logs tell it; they tell none where the model does not fit.
        resampled: how many times as wide the interval is that resampled stretches of the logs give.
        at_end: whether it lies at an end of its range.
        unit: SI.
        meaning: what it is.
    """

    value: float
    low: float
    high: float
    identifiable: bool
    resampled: float
    at_end: bool
    unit: str
    meaning: str

    def __repr__(self) -> str:
        low, value, high = (
            quantity(one, self.unit).replace(MINUS, "-") for one in (self.low, self.value, self.high)
        )
        return f"{value} ({low} ... {high})" if self.identifiable else f"{value} (not told by the logs)"


class SignalFit(NamedTuple):
    """How well a signal of a log is met.

    Attributes:
        rms: of measured less simulated, in the signal's unit.
        noise: the deviation of that from its median, which outliers do not change.
        explained: the share of the measured variance that the model explains, 1 for all.
        whiteness: the probability that white noise would hang together as the residuals do.
        correlation: of a residual with the next.
        held_out: rms over the last fifth, simulated with what the rest of the log gives.
        held_in: rms over the rest, of the same fit.
        offset: of the sensor, and its standard deviation; both 0 where none is sought.
        problem: why the model does not fit it; empty where it does.
        unit: SI.
    """

    rms: float
    noise: float
    explained: float
    whiteness: float
    correlation: float
    held_out: float
    held_in: float
    offset: tuple[float, float]
    problem: str
    unit: str


class LogFit(NamedTuple):
    """A log as it was understood and met.

    Attributes:
        understood: what was taken of it.
        delay: of what is measured against the command [s], and its standard deviation.
        signals: by name.
        data: over ``time`` [s], measured signals and, with ``_simulated`` after their names, the model's.
    """

    understood: Understood
    delay: tuple[float, float]
    signals: Mapping[str, SignalFit]
    data: "xr.Dataset"


class Identified(NamedTuple):
    """What an identification found.

    Attributes:
        scenario: whose machine it is.
        loop: the scenario's loop with what was found.
        parameters: by path.
        uncertain: numbers that were not sought, but freed within their ``[uncertainty]``, by path.
        fits: whether the model fits all signals; predictions are not judged.
        effects: what the scenario leaves out and a model that does not fit may miss, the likeliest first.
        correlations: of the parameters, shape (parameters, parameters).
        logs: each as it was met.
        remarks: what a user should know, in a line each.
        tables: what was found, over the scenario: its machine, and its uncertainty from the intervals.
        evaluations: of all residuals with their slopes.
        horizon: of predictions [s]; None if the whole log was simulated.
        fitted: what was fitted to what, for further questions.
    """

    scenario: str
    loop: Loop
    parameters: Mapping[str, Estimate]
    uncertain: Mapping[str, Estimate]
    fits: bool
    effects: Sequence[Effect]
    correlations: NDArray[np.float64]
    logs: Sequence[LogFit]
    remarks: Sequence[str]
    tables: Mapping[str, Any]
    evaluations: int
    horizon: float | None
    fitted: Fitted

    def toml(self, folder: Path | str = ".") -> str:
        """The text of a scenario with what was found, which builds on the one that was fitted.

        Args:
            folder: where its file will stand, from which a scenario in a file is found again.
        """
        logs = ", ".join(one.understood.log.name for one in self.logs)
        remarks = [] if self.fits else self.remarks
        return on_base(self.scenario, self.tables, folder, f"identify {self.scenario} from {logs}", remarks)

    def __repr__(self) -> str:
        numbers = [f"{path} = {one!r}" for path, one in {**self.parameters, **self.uncertain}.items()]
        return "\n".join([*numbers, *self.remarks])

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        heads = ("parameter", "value", "95 % interval", "the logs", "meaning")
        rows = [parameter_row(path, one, fits=self.fits) for path, one in self.parameters.items()]
        logs = [row for fit in self.logs for row in signal_rows(fit)]
        return (
            html_heading(self.scenario, "with what its logs tell")
            + html_table(heads, rows)
            + html_table(("log", "signal", "left, rms", "held out", "explained"), logs)
            + html_remarks(self.remarks)
        )


def parameter_row(path: str, one: Estimate, *, fits: bool) -> tuple[str, ...]:
    """A number with its interval, which it has where the model fits, in one unit."""
    unit, (low, value, high) = column([one.low, one.value, one.high], one.unit)
    told = "tell it" if one.identifiable else Strong("do not tell it")
    return path, Strong(f"{value} {unit}".strip()), f"{low} to {high}" if fits else NONE, told, one.meaning


def signal_rows(fit: LogFit) -> Iterator[tuple[str, ...]]:
    """How each signal of a log is met."""
    for name, one in fit.signals.items():
        left, apart = (quantity(rms, one.unit) for rms in (one.rms, one.held_out))
        yield fit.understood.log.name, name, left, apart, f"{number(100.0 * one.explained)} %"
