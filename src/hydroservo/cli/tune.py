"""The command that searches gains."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.frame import CommandOutput, typed_command, with_output
from hydroservo.cli.interrupts import INTERRUPTED, acknowledge_interrupt
from hydroservo.cli.messages import Report, log_kernels
from hydroservo.cli.options import (
    VARY,
    Changes,
    Plugins,
    Scenarios,
    Threads,
    Verbose,
    load_with_warnings,
    parse_ranges,
    replay_command,
    vary_option,
)
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.formatting import quantity
from hydroservo.core.outputs import write_text

if TYPE_CHECKING:
    from hydroservo.runs.tuned import Tuned
    from hydroservo.runs.tuning import SearchProgress
    from hydroservo.scenario.tuning_task import TuningTask
    from hydroservo.show import Finding


@with_output(
    "Write the values found as TOML tables to paste into a scenario (.toml); into a folder a report too.",
    endings=(".toml",),
)
def tune_command(
    scenarios: Scenarios,
    changes: Changes,
    plugins: Plugins,
    ranges: Annotated[
        list[str],
        vary_option(
            "Search a number of the controller or the sensors between two values, such as "
            "0.1..30 V s/m, or relative to that of the first scenario, such as -50%..+100% or "
            "x0.5..x2; evenly in its logarithm if the range does not hold 0. [default: `[tune.vary]`]"
        ),
    ],
    output: CommandOutput,
    metric: Annotated[
        str | None,
        typer.Option("--metric", metavar="NAME", show_default="rms_error", help="The metric to minimise."),
    ] = None,
    weights: Annotated[
        str | None,
        typer.Option(
            "--weights",
            metavar="W,W,...",
            show_default="all 1",
            help="Weight of each scenario in the geometric mean of their metrics.",
        ),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(
            "--seeds",
            metavar="N",
            show_default="1",
            help="Seeds over which each scenario's metric is averaged, from its own on.",
        ),
    ] = None,
    effort: Annotated[
        float | None,
        typer.Option(
            "--effort",
            metavar="E",
            show_default="0",
            help="Multiply each metric by the E-th power of the command's total variation: with 0.1, one "
            "a tenth as lively is worth a fifth of the metric.",
        ),
    ] = None,
    scales: Annotated[
        str | None,
        typer.Option(
            "--scales",
            metavar="S,S,...",
            show_default="that of each",
            help="Take each scenario at several scales of its uncertainty, such as -1,0,1, for values that "
            "serve all these machines.",
        ),
    ] = None,
    candidates: Annotated[
        int | None,
        typer.Option(
            "--candidates",
            metavar="N",
            show_default="4096",
            help="How many sets of values to try; rounded up to a multiple of 64. 0: no search, but a first "
            "guess from the natural frequency of the first scenario's axis.",
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            "--seed", metavar="S", show_default="0", help="Seed of the search, a whole number >= 0."
        ),
    ] = None,
    bounded: Annotated[
        bool | None,
        typer.Option(
            "--bounded/--unbounded",
            show_default="bounded",
            help="Keep the bounds below on all machines of the scenarios' uncertainty, and allow no "
            "oscillation that lasts; or search the least metric, whatever the margins.",
        ),
    ] = None,
    gain_margin: Annotated[
        str | None,
        typer.Option(
            "--gain-margin",
            metavar="GAIN",
            show_default="6 dB",
            help="Least gain margin while moving, with which the loop does not oscillate either.",
        ),
    ] = None,
    phase_margin: Annotated[
        str | None,
        typer.Option(
            "--phase-margin", metavar="ANGLE", show_default="30 deg", help="Least phase margin while moving."
        ),
    ] = None,
    max_sensitivity: Annotated[
        str | None,
        typer.Option(
            "--max-sensitivity",
            metavar="GAIN",
            show_default="6 dB",
            help="Largest sensitivity peak while moving.",
        ),
    ] = None,
    threads: Threads = None,
    verbose: Verbose = False,
) -> None:
    """Search for the numbers of one or more scenarios that minimise a metric.

    Several scenarios are tuned together, for one set of values that serves all: what is made small is the
    geometric mean of their metrics. A run that diverges is worse than any that does not. The best values
    leave 6 dB of gain margin, 30 degrees of phase margin and a sensitivity peak of 6 dB, and no oscillation
    that lasts, unless options say otherwise. The same seed finds the same values again; another one may find
    better ones. Ctrl-C ends the search with the best values so far.

    What no option sets is taken from the table `[tune]` of the first scenario. Several scenarios on the
    command line replace those in `[tune]`, and their weights.

    A folder as --out gets a report (report.html, its tables as CSV and LaTeX in tables), the values as TOML
    (gains.toml), pictures of the metric before and after and of the error against the command's activity
    (tuned.png, front.png, and as SVG), and the numbers (metrics.json).

    Examples:

    - `hydroservo tune rig/1khz-pi-sine --out found`
    - `hydroservo tune axis/pump-controlled --candidates 0`
    - `hydroservo tune rig/1khz-pi-sine --vary controller.proportional_gain=0.3..30 --vary
      controller.integral_gain=10..5000`
    - `hydroservo tune rig/1khz-pi-sine rig/1khz-pi-square --weights 1,8 --vary
      "controller.proportional_gain=0.3..30 V s/m" --vary "controller.integral_gain=10..5000 V/m" --out
      gains.toml`
    - `hydroservo tune rig/noisy-1khz-pi-sine --seeds 20 --metric max_error --vary
      controller.proportional_gain=-50%..+100%`
    """
    from hydroservo.runs.objective import metric_field
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.tuning import best_values, without_none
    from hydroservo.scenario.tuning_task import task_of_scenarios

    lists = without_none(weights=weights, scales=scales)
    plain = without_none(metric=metric, seeds=seeds, effort=effort, candidates=candidates, seed=seed)
    plain |= without_none(
        bounded=bounded, gain_margin=gain_margin, phase_margin=phase_margin, max_sensitivity=max_sensitivity
    )
    parts = plain | {name: parse_numbers(text) for name, text in lists.items()}
    overrides = dict(map(parse_override, changes))
    with errors_name_options(plain | lists):
        task = task_of_scenarios(
            scenarios, parse_ranges(ranges), parts, overrides, plugins, load=load_with_warnings
        )
    unit = metric_field(task.aim.loops, task.aim.metric).unit

    def ask(report: Report) -> "Tuned":
        with log_kernels(verbose):
            progress = progress_with_best(report, unit, task)
            return best_values(
                task, threads, progress, lambda: acknowledge_interrupt("; the best values so far are above")
            )

    say = partial(describe_tuned, typed_command(output.context), task.scenarios, changes, plugins)
    raise typer.Exit(INTERRUPTED if output.present("", ask, say).interrupted else 0)


def describe_tuned(
    command: Sequence[str],
    scenarios: Sequence[str],
    changes: Sequence[str],
    plugins: Sequence[Path],
    tuned: "Tuned",
) -> "Finding":
    """What a search says, with the command that runs the best values, and their file."""
    from hydroservo.runs.tuned import tuned_finding
    from hydroservo.scenario.tuning import as_toml, comments_of

    words = ["hydroservo", "run" if len(scenarios) == 1 else "compare", *scenarios]
    again = replay_command(words, changes, plugins, tuned.parameters)
    text = as_toml(tuned.parameters, " \\\n    ".join(command), comments_of(tuned))
    finding = tuned_finding(tuned, scenarios, " ".join(command), again)
    return finding._replace(files={"gains.toml": lambda path: write_text(path, text)})


def parse_numbers(text: str) -> list[float]:
    """Numbers with commas between them; one that is none for a text that is not that."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        return [math.nan]


@contextmanager
def errors_name_options(options: Mapping[str, object]) -> Iterator[None]:
    """Errors about what options say name the option, and what was typed."""
    try:
        yield
    except ParameterError as error:
        if error.path == "ranges":
            problem = f"nothing to search: give {VARY} PATH=LOW..HIGH, or the scenario [tune.vary]"
            raise HydroservoError(problem) from None
        if error.path not in options:
            raise
        allowed, semicolon, count = error.allowed.partition(";")
        if error.path in ("weights", "scales") and allowed.startswith("must"):
            allowed += ", with commas between them"
        option = f"--{error.path.replace('_', '-')}"
        raise ParameterError(option, options[error.path], f"{allowed}{semicolon}{count}") from None


def progress_with_best(report: Report, unit: str, task: "TuningTask") -> "SearchProgress":
    """Reports how many candidates are done, and the best so far."""
    candidates, none = task.candidates, "none within bounds yet" if task.bounds else "best diverged"

    def progress(fraction: float, best: float) -> None:
        text = f"best {quantity(best, unit)}" if best < float("inf") else none
        report(fraction, f"{round(fraction * candidates):,} of {candidates:,} candidates, {text}")

    return progress
