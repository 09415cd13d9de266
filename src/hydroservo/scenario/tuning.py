"""Scenarios tuned by their names, as their tables ``[tune]`` say."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from hydroservo._version import __version__
from hydroservo.control.wiring import wired
from hydroservo.core.block import replace
from hydroservo.core.errors import HydroservoWarning, ParameterError
from hydroservo.linear.first_guess import FirstGuess, first_guess
from hydroservo.linear.margins import NO_SLOPE_ERRORS
from hydroservo.linear.moving_margins import is_unstable
from hydroservo.linear.stability import LoopGuard, stability_changes
from hydroservo.runs.arguments import checked_loops, checked_mapping
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.objective import Aim, check_ranges
from hydroservo.runs.tuned import Tuned
from hydroservo.runs.tuning import SearchProgress, guessed_gains, search_gains
from hydroservo.scenario.ranges import as_entries
from hydroservo.scenario.scenario_files import nest_changes
from hydroservo.scenario.tuning_task import TuningTask, task_of_aim, task_of_scenarios
from hydroservo.work.cores import single_threaded_algebra
from hydroservo.work.notebook_bar import shows_progress

NO_GUESS = (
    "is a first guess without a search, and there is none here: it is for a PI, a PID or a Cascade that "
    "controls a position or a velocity of an axis that swings on its oil"
)


@single_threaded_algebra()
@shows_progress
def tune(
    aim: Aim | str | Path | Sequence[str | Path],
    ranges: Mapping[str, str | tuple[float, float]] | None = None,
    *,
    metric: str | None = None,
    weights: Sequence[float] | None = None,
    seeds: int | None = None,
    effort: float | None = None,
    scales: Sequence[float] | None = None,
    candidates: int | None = None,
    seed: int | None = None,
    bounded: bool | None = None,
    gain_margin: float | str | None = None,
    phase_margin: float | str | None = None,
    max_sensitivity: float | str | None = None,
    changes: Mapping[str, object] | None = None,
    plugins: Sequence[str | Path] | None = None,
    threads: int | None = None,
    progress: SearchProgress | None = None,
) -> Tuned:
    """Search the numbers that make a metric smallest, of scenarios as ``hydroservo tune`` does or of loops::

        found = tune("rig/1khz-pi-square", candidates=512)
        loop = load_scenario("rig/1khz-pi-square", found.parameters)

        found = tune(Aim([loop]), {"controller.proportional_gain": (0.3, 30.0)})

    What no argument says is as the table ``[tune]`` of the first scenario says. Several scenarios stand in
    place of those, and of their weights, in ``[tune]``. The search is that of
    :func:`hydroservo.runs.tuning.search_gains`: the same seed gives the same result on any number of
    threads, and that of the command.

    Args:
        aim: what is to be small: one scenario or several, by name or path; or an
            :class:`~hydroservo.runs.objective.Aim`, which takes nothing of ``metric`` to ``scales``,
            ``changes`` and ``plugins``.
        ranges: between what each number of the controller or the sensors is searched, by path, in place of
            all of ``[tune.vary]``: two numbers in SI units, ``hs.relative(low, high)`` around the value in
            the first scenario, or a text as ``--vary`` takes it, such as ``"0.3..30 V s/m"``. For an aim two
            numbers.
        metric: name of the metric that is to be small.
        weights: of each scenario in the geometric mean of their metrics.
        seeds: how many seeds each scenario's metric is averaged over, from its own on.
        effort: exponent of the command's total variation, a factor on each metric, at least 0.
        scales: of the uncertainty, at each of which each scenario is taken.
        candidates: how many sets of numbers are tried; rounded up to a multiple of 64; 4096 if nothing says.
            With 0 there is no search, and no ranges: the values are those of
            :func:`~hydroservo.linear.first_guess.first_guess`.
        seed: of the search; 0 if nothing says.
        bounded: whether the best must keep the bounds that follow, and not oscillate, on the machines of the
            search and of the scenarios' uncertainty; True if nothing says.
        gain_margin: that the loops have at least while they move, a factor or a text; "6 dB" if nothing says.
            They do not oscillate with that gain either.
        phase_margin: that they have at least [rad], or a text; "30 deg" if nothing says.
        max_sensitivity: the most that their sensitivity peak is, a factor or a text; "6 dB" if nothing says.
        changes: values by dotted path that override those of the scenarios, as for ``load_scenario``.
        plugins: Python files with blocks that the scenarios name; they are executed.
        threads: how many to use; all cores if None.
        progress: called after each generation with the fraction done and the best geometric mean so far.

    Returns:
        The best values, and the metric of each loop before and after, named by its scenario. An interrupt
        ends the search with the best values so far.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
        ParameterError: an argument is not what it must be.
        HydroservoError: with every candidate some run diverged, or none keeps the bounds.

    Warns:
        HydroservoWarning: what is to be known of the runs with the best values, as for simulate_batch.

    Source: Storn, Price, Journal of Global Optimization 11, 1997, doi:10.1023/A:1008202821328.
    Fails to promise the best there is: another seed may find a better one.
    """
    parts = without_none(metric=metric, weights=weights, seeds=seeds, effort=effort, scales=scales)
    length = without_none(candidates=candidates, seed=seed, bounded=bounded) | without_none(
        gain_margin=gain_margin, phase_margin=phase_margin, max_sensitivity=max_sensitivity
    )
    ranges = checked_mapping("ranges", {} if ranges is None else ranges, "paths to ranges")
    if isinstance(aim, Aim):
        others = parts | without_none(changes=changes, plugins=plugins)
        task = task_of_aim(aim, ranges, length, others)
    else:
        asked, changes = as_entries(ranges), {} if changes is None else changes
        task = task_of_scenarios(as_sources(aim), asked, parts | length, changes, plugins or ())
    found = best_values(task, threads, progress)
    for line in dict.fromkeys(line for table in found.tables for line in warnings_of(table)):
        warnings.warn(line, HydroservoWarning, stacklevel=4)  # past the decorators
    return found


def best_values(
    task: TuningTask,
    threads: int | None,
    progress: SearchProgress | None,
    interrupted: Callable[[], None] = lambda: None,
) -> Tuned:
    """The best values of a task's search, under the names of its loops, and how the loops stand with them."""
    if task.candidates:
        check_ranges([wired(loop) for loop in checked_loops(task.aim.loops)], task.ranges)
    guard = LoopGuard(task.bounds, task.machines, threads) if task.bounds else None
    aim, ranges = task.aim, task.ranges
    rule = guess_of(task)
    guess = {path: value for path, value in rule.parameters.items() if path in ranges} if rule else {}
    if task.candidates:
        found = search_gains(
            aim, ranges, task.candidates, task.seed, threads, progress, guard, guess, interrupted
        )
    elif rule:
        try:
            found = guessed_gains(aim, rule.parameters, threads, guard)._replace(rule=rule)
        except ParameterError as error:
            allowed = f"is a first guess for the law of the first scenario, and another has {error.allowed}"
            raise ParameterError("candidates", 0, allowed) from None
    else:
        raise ParameterError("candidates", 0, NO_GUESS)
    names = task.names or found.names
    found = found._replace(names=names, aim=aim, ranges=ranges, bounds=task.bounds, typed=task.typed)
    if guard is None:
        loops = zip(names, task.aim.loops, strict=True)
        unstable = [name for name, loop in loops if is_unstable(replace(wired(loop), found.parameters))]
        return found._replace(unstable=unstable)
    return found._replace(margins=stability_changes(task.machines, found.parameters))


def guess_of(task: TuningTask) -> FirstGuess | None:
    """A first guess from the first loop's machine, in five digits; None where there is none."""
    try:
        guess = first_guess(task.aim.loops[0])
    except NO_SLOPE_ERRORS:
        return None
    if guess is None:
        return None
    return guess._replace(parameters={path: float(f"{one:.5g}") for path, one in guess.parameters.items()})


def without_none(**arguments: object) -> dict[str, Any]:
    """Those of some arguments that are not None."""
    return {name: value for name, value in arguments.items() if value is not None}


def as_sources(value: object) -> Sequence[str | Path]:
    """One scenario or several as a list."""
    every = value if isinstance(value, list | tuple) else [value]
    found = [one for one in every if isinstance(one, str | Path)]
    if not found or len(found) < len(every):
        raise ParameterError(
            "aim", value, "must be an Aim, such as Aim([loop]), or scenarios by name or path"
        )
    return found


def comments_of(tuned: Tuned) -> list[str]:
    """Why the values may not be those that the command beside them finds, or may be of no use."""
    interrupted = f"The search was interrupted after {tuned.candidates:,} candidates."
    no_better = "They are no better than those of the scenario."
    return [*([interrupted] if tuned.interrupted else []), *([no_better] if tuned.no_better else [])]


def as_toml(parameters: Mapping[str, float], command: str, remarks: Sequence[str] = ()) -> str:
    """Values in SI units by path, as TOML tables to paste into a scenario, under what found them."""
    comment = "".join(f"# {line}\n" for line in [*command.splitlines(), *remarks])
    tables = tomli_w.dumps(nest_changes(parameters))
    return f"# In SI units, found by hydroservo {__version__} with\n{comment}\n{tables}"
