"""Parameters of a scenario's machine from logs."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from hydroservo.core.block import Field, field_at
from hydroservo.core.command_scale import commands_in
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.validation import checked_number, whole_number
from hydroservo.identification.conclusions import remarks_of
from hydroservo.identification.effects import effects_left_out
from hydroservo.identification.experiment import LOAD
from hydroservo.identification.log import EXTERNAL_FORCE, LogSource, SignalLog, log_mapping, read_logs
from hydroservo.identification.log_check import check_balance, check_positions, stroke_of
from hydroservo.identification.prediction import best_prediction
from hydroservo.identification.problem import DELAY, Problem, lie_at_ends
from hydroservo.identification.problem_setup import fit_problem, uncertain_numbers
from hydroservo.identification.quality import held_out_errors, log_fits
from hydroservo.identification.regression import NORMAL
from hydroservo.identification.result import Estimate, FittedProblem, Identified, tables_or_remark
from hydroservo.identification.search import Report, Solution, best_fit, misfit_at
from hydroservo.identification.segments import UnderstoodLog, understand_log
from hydroservo.identification.uncertainty import Uncertainty, are_identifiable, uncertainty
from hydroservo.runs.arguments import checked_mapping
from hydroservo.scenario.load import Assembly, MachineBlocks, assemble
from hydroservo.scenario.parameter_draws import Variation, variations
from hydroservo.scenario.ranges import as_entries, both_ends
from hydroservo.scenario.tables import TableEntry
from hydroservo.work.cores import checked_count, single_threaded_algebra
from hydroservo.work.notebook_bar import shows_progress

LARGEST_SEED = 2**53 - 1
HORIZON = Field("s", "time in which a prediction forgets", above=0)
LATE = Field("s", "by which what is measured comes after the command")
STROKE = "plant.stroke"


@single_threaded_algebra()
@shows_progress
def identify(
    source: str | Path,
    logs: LogSource | Sequence[LogSource],
    ranges: Mapping[str, str | tuple[float, float]],
    *,
    changes: Mapping[str, object] | None = None,
    plugins: Sequence[str | Path] = (),
    seed: int = 0,
    horizon: float | None = None,
    threads: int | None = None,
    progress: Report | None = None,
) -> Identified:
    """Find numbers of a scenario's machine from logs of it, as ``hydroservo identify`` does::

        found = hs.identify("axis.toml", "bench.csv", {"plant.oil.effective_bulk_modulus": "5000..15000 bar"})
        found.parameters["plant.oil.effective_bulk_modulus"].low

    The recorded command drives the machine of the scenario in place of its law, and a recorded external force
    in place of its load; what is sought makes the difference of measured and simulated signals least. With
    each log its delay, its sensors' offsets and the state in which it begins are sought too.

    Args:
        source: the scenario, by name or path. Its table ``[identify.columns]`` says which column of a log
            holds which signal where the header does not.
        logs: one or several: files (CSV, Parquet, MATLAB, NetCDF, HDF5, MDF, TDMS), or mappings of ``time``,
            ``command`` and measured signals to arrays of shape (n,) in SI units.
        ranges: between what each number of the machine is sought, by path: two numbers in SI units,
            ``hs.relative(low, high)`` or a text as ``--vary`` takes it. They go before those of the
            scenario's table ``[identify.vary]``. The range of ``delay`` [s] holds for each log; by
            default -1.5 samples to 1 s or a tenth of the log, whichever is less.
        changes: values by dotted path that override those of the scenario.
        plugins: Python files with blocks that it names; they are executed.
        seed: of the starts of the search.
        horizon: None holds a simulation of the whole log against what was measured. A time [s] holds
            predictions against it, which follow what was measured and forget within that time: for logs in
            which a load or a drift acts that no one recorded, and little noise.
        threads: how many to use; all cores if None.
        progress: called now and then with the fraction done.

    Returns:
        The numbers with 95 % intervals, which of them the logs tell, how each log is met, and a scenario with
        what was found.

    Raises:
        ScenarioError: in one line, the file, the place and what is wrong there, such as signals that
            contradict each other.
        ParameterError: an argument is not what it must be.
        HydroservoError: every run is lost.

    Source: Ljung, System Identification, 1999, ch. 7 and 9 (output error and its covariance); Huber, Robust
    Statistics, 1981.
    Fails where what is measured depends on something that neither the log nor the scenario knows, as friction
    on how long the machine stood; residuals that are not white tell.
    """
    asked = as_entries(checked_mapping("ranges", ranges, "paths to ranges"))
    given = [logs] if isinstance(logs, str | Path | Mapping) else list(logs)
    return identify_entries(
        source,
        given,
        asked,
        changes or {},
        plugins,
        seed,
        horizon,
        checked_count(threads, "threads"),
        progress,
    )


def identify_entries(
    source: str | Path,
    logs: Sequence[LogSource],
    ranges: Mapping[str, TableEntry],
    changes: Mapping[str, object],
    plugins: Sequence[str | Path],
    seed: int,
    horizon: float | None,
    threads: int,
    progress: Report | None,
) -> Identified:
    """As :func:`identify`, of ranges as they were read."""
    report = progress or (lambda _: None)
    whole_number("seed", seed, 0, LARGEST_SEED)
    if horizon is not None:
        checked_number(horizon, "horizon", HORIZON, float)
    assembly = assemble(source, changes, plugins)
    all_ranges = {**assembly.log_ranges, **ranges}
    delays = both_ends(all_ranges[DELAY], LATE, None) if DELAY in all_ranges else None
    varied = sought_variations(assembly, {path: entry for path, entry in all_ranges.items() if path != DELAY})
    taken = [understand_log(one, i) for i, one in enumerate(read_scenario_logs(logs, assembly))]
    strokes = [one.high for one in varied if one.path == STROKE]
    check_positions(taken, max([stroke_of(assembly.loop.plant), *strokes]))
    check_loads(taken, varied)
    check_balance(taken, assembly.loop, driven=False)
    idle = [LOAD] if forces_recorded(taken) else []
    freed = uncertain_numbers(assembly, varied, idle) if horizon is None else []
    problem = fit_problem(assembly, varied, freed, taken, threads, delays)
    problem, best = solve_problem(problem, seed, horizon, report)
    shown = misfit_at(problem, best.x, best.weights)
    sure = uncertainty(problem, shown, seed)
    report(0.9)
    met = log_fits(problem, best, sure, taken, held_out_errors(problem, best), assembly.loop.sensors)
    logs_met = [fit._replace(horizon=horizon) for fit in met]
    fits = not any(one.problem for fit in logs_met for one in fit.signals.values())
    every = parameter_estimates(assembly, problem, best, sure, fits=fits)
    parameters = {one.path: every[one.path] for one in varied}
    effects = [] if fits else effects_left_out(problem, best, shown)
    remarks = remarks_of(problem, parameters, sure, logs_met, effects)
    count = len(parameters)
    tables, problems = tables_or_remark(source, changes, plugins, every)
    report(1.0)
    return Identified(
        str(source),
        assemble(source, tables, plugins).loop,
        parameters,
        {path: one for path, one in every.items() if path not in parameters},
        fits,
        effects,
        sure.correlations[:count, :count],
        logs_met,
        [*remarks, *problems],
        tables,
        best.evaluations,
        horizon,
        FittedProblem(assembly, problem, best, sure),
    )


def solve_problem(
    problem: Problem, seed: int, horizon: float | None, report: Report
) -> tuple[Problem, Solution]:
    """The numbers with which least is left of a simulation, or of predictions with their observer."""
    report(0.05)
    share = 0.75 if horizon is None else 0.35
    problem, best = best_fit(problem, seed, lambda part: report(0.05 + share * part))
    if horizon is None:
        return problem, best
    return best_prediction(problem, best, horizon, lambda part: report(0.4 + 0.4 * part))


def sought_variations(assembly: Assembly, ranges: Mapping[str, TableEntry]) -> list[Variation]:
    if not ranges:
        problem = (
            "must name a number of the machine that is sought (--vary), or the scenario have [identify.vary]"
        )
        raise ParameterError("ranges", "{}", problem)
    for path, entry in ranges.items():
        head = path.partition(".")[0]
        if head in ("controller", "reference", "sensors", "hold", "simulation"):
            machine = ", ".join(MachineBlocks._fields)
            problem = f"must be of the machine ({machine}): a log takes the place of the {head}"
            raise ScenarioError(entry.origin.name, entry.key, problem)
    return variations(assembly, ranges)


def read_scenario_logs(logs: Sequence[LogSource], assembly: Assembly) -> list[SignalLog]:
    with commands_in(assembly.loop.command):
        every = read_logs(logs, log_mapping(assembly.log_columns))
    period = assembly.loop.simulation.period
    for log in every:
        lasts = float(log.time[-1] - log.time[0])
        if lasts < period:
            problem = f"lasts {lasts:g} s, less than the scenario's sample period of {period:g} s"
            raise ScenarioError(log.name, "", problem)
    return every


def check_loads(taken: Sequence[UnderstoodLog], varied: Sequence[Variation]) -> None:
    """Refuse to seek a load in logs of which each recorded the force in its place."""
    if forces_recorded(taken):
        for one in varied:
            if one.path.startswith(LOAD):
                problem = f"must not be sought here: the logs' {EXTERNAL_FORCE} takes the place of the load"
                raise ScenarioError(one.entry.origin.name, one.path, problem)


def forces_recorded(taken: Sequence[UnderstoodLog]) -> bool:
    """Whether each log recorded the force in the place of the load."""
    return all(EXTERNAL_FORCE in one.inputs for log in taken for one in log.segments)


def parameter_estimates(
    assembly: Assembly, problem: Problem, best: Solution, sure: Uncertainty, *, fits: bool
) -> dict[str, Estimate]:
    """The parameters with their intervals, which are even in the units of the search."""
    count = len(problem.space.ranges)
    half = NORMAL * sure.deviations
    low, value, high = (
        problem.space.values(np.clip(best.x + sign * half, 0.0, 1.0)[np.newaxis, :count])
        for sign in (-1.0, 0.0, 1.0)
    )
    ended = lie_at_ends(problem, best.x)[:count]
    told = fits & ~ended & are_identifiable(problem, best.x, best.weights, sure)
    wider = sure.resampled / sure.deviations
    found = {}
    for i, path in enumerate(problem.space.ranges):
        argument = assembly.arguments.get(path)
        field = argument.field if argument is not None else field_at(assembly.loop, path)
        ends = float(low[path][0]), float(high[path][0])
        found[path] = Estimate(
            float(value[path][0]),
            *ends,
            bool(told[i]),
            float(wider[i]),
            bool(ended[i]),
            field.unit,
            field.meaning,
        )
    return found
