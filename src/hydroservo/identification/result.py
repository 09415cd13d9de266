"""What an identification found, also as tables of a scenario over the one that was fitted."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo._version import __version__
from hydroservo.control.loop import Loop
from hydroservo.core.block import leaves
from hydroservo.core.errors import HydroservoError, ScenarioError, one_line
from hydroservo.core.formatting import plain_quantity
from hydroservo.identification.effects import LeftOutEffect
from hydroservo.identification.finding import identified_finding, log_fit_finding
from hydroservo.identification.problem import Problem
from hydroservo.identification.search import Solution
from hydroservo.identification.segments import UnderstoodLog
from hydroservo.identification.uncertainty import Uncertainty
from hydroservo.scenario.load import Assembly, MachineBlocks, assemble
from hydroservo.scenario.other_tables import TrueValue
from hydroservo.scenario.scenario_files import builtin_texts, nest_changes
from hydroservo.show import Finding
from hydroservo.show.html import html_of

if TYPE_CHECKING:
    import xarray as xr

CLOSE = 1e-9  # relative difference that digits may make

Changes = Mapping[str, object]


def scenario_on_base(
    scenario: str, tables: Mapping[str, Any], folder: Path | str, command: str, remarks: Sequence[str] = ()
) -> str:
    """TOML that lays what was found over a scenario."""
    import tomli_w

    base = scenario if scenario in builtin_texts() else os.path.relpath(scenario, folder)
    origin = one_line(f"# Found by hydroservo {__version__} {command}; SI units.")
    lines = [origin, *(one_line(f"# {one}") for one in remarks)]
    return "\n".join(lines) + f"\n{tomli_w.dumps({'base': base, **tables})}"


class FittedProblem(NamedTuple):
    """What was fitted to what."""

    assembly: Assembly  # the scenario
    problem: Problem  # parameters and logs
    best: Solution  # where the search ended
    sure: Uncertainty  # how sure that is


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
        low, value, high = (plain_quantity(one, self.unit) for one in (self.low, self.value, self.high))
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
        horizon: of predictions [s]; None if the whole log was simulated.
    """

    understood: UnderstoodLog
    delay: tuple[float, float]
    signals: Mapping[str, SignalFit]
    data: "xr.Dataset"
    horizon: float | None = None

    def finding(self) -> Finding:
        """What it says, as ``hs.plot`` shows it."""
        return log_fit_finding(self)


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
    effects: Sequence[LeftOutEffect]
    correlations: NDArray[np.float64]
    logs: Sequence[LogFit]
    remarks: Sequence[str]
    tables: Mapping[str, Any]
    evaluations: int
    horizon: float | None
    fitted: FittedProblem

    def toml(self, folder: Path | str = ".") -> str:
        """The text of a scenario with what was found, which builds on the one that was fitted.

        Args:
            folder: where its file will stand, from which a scenario in a file is found again.
        """
        logs = ", ".join(one.understood.log.name for one in self.logs)
        remarks = [] if self.fits else self.remarks
        return scenario_on_base(
            self.scenario, self.tables, folder, f"identify {self.scenario} from {logs}", remarks
        )

    def __repr__(self) -> str:
        numbers = [f"{path} = {one!r}" for path, one in {**self.parameters, **self.uncertain}.items()]
        return "\n".join([*numbers, *self.remarks])

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return identified_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())


def tables_or_remark(
    source: str | Path, changes: Changes, plugins: Sequence[str | Path], found: Mapping[str, Estimate]
) -> tuple[dict[str, Any], list[str]]:
    """The tables of a scenario with what was found as its machine, and its uncertainty from the covariance.

    ``[uncertainty]`` holds half the width of each 95 % interval that the logs tell, relative to the value, at
    scale 0: a run is with the values found, and ``--set uncertainty.scale=1`` goes to the interval's end.
    What the scenario had there before counts in ``[truth]`` from now on. A number that a constructor computes
    cannot stand beside what it computes it from, and goes into ``[truth]`` too, in which the law does not
    believe. Where no scenario can say what was found, the tables stay, and a remark says why: no problem must
    cost a result.
    """
    try:
        before = assemble(source, changes, plugins)
        values = {path: estimate.value for path, estimate in found.items()}
        own: dict[str, Any] = dict(changes)
        for path, value in values.items():
            own |= {written_path(source, own, plugins, path, value): value}
        own |= truth_changes(before, values, own)
        own |= uncertainty_changes(found, own)
        check_written_tables(assemble(source, own, plugins), before, values)
    except HydroservoError as error:
        return nest_changes(changes), [f"the scenario is written without what was found: {error}"]
    return nest_changes(own), []


def written_path(
    source: str | Path, changes: Changes, plugins: Sequence[str | Path], path: str, value: float
) -> str:
    """Where a value can be said: at its own path, or as a truth where a constructor computes the number."""
    try:
        assemble(source, {**changes, path: value}, plugins)
    except ScenarioError:
        return f"truth.{path}"
    return path


def truth_changes(before: Assembly, values: Mapping[str, float], own: Changes) -> dict[str, float]:
    """What the scenario's uncertainty made of other numbers, and what must outdo a truth of it."""
    loop, said = dict(leaves(before.loop)), {**before.truth.arguments, **before.truth.numbers}
    taken = {
        f"{name}.{path}": value
        for name in MachineBlocks._fields
        for path, value in before.truth.taken(name, before.arguments).items()
    }
    kept = {path: float(taken.get(path, loop.get(path, 0.0))) for path in said if path not in values}
    outdone = {path: value for path, value in values.items() if isinstance(said.get(path), TrueValue)}
    return {f"truth.{path}": value for path, value in (kept | outdone).items() if f"truth.{path}" not in own}


def uncertainty_changes(found: Mapping[str, Estimate], own: Changes) -> dict[str, float]:
    """Relative deviations of what the logs tell, at scale 0."""
    relative = {
        f"uncertainty.{path}": 0.5 * (one.high - one.low) / abs(one.value)
        for path, one in found.items()
        if one.identifiable and one.value and f"truth.{path}" not in own
    }
    return {"uncertainty.scale": 0.0, **relative}


def check_written_tables(written: Assembly, before: Assembly, values: Mapping[str, float]) -> None:
    """Refuse to write what is not the machine found."""
    told = dict(leaves(MachineBlocks(*(getattr(written.loop, name) for name in MachineBlocks._fields))))
    old = dict(leaves(MachineBlocks(*(getattr(before.loop, name) for name in MachineBlocks._fields))))
    for path, value in values.items():
        if path in told and abs(told[path] - value) > CLOSE * abs(value):
            raise HydroservoError(
                f"{path}: a scenario cannot give {value:g} here; it would be {told[path]:g}"
            )
    if not before.arguments.keys() & values.keys():
        for path in told.keys() - values.keys():
            if isinstance(told[path], float) and abs(told[path] - old[path]) > CLOSE * abs(old[path]):
                raise HydroservoError(
                    f"{path}: follows from what was found, and cannot be written as a scenario"
                )
