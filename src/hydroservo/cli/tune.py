"""The command that searches gains."""

import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.options import Changes, Json, Plugins, Verbose, loaded
from hydroservo.cli.remarks import say_remarks

if TYPE_CHECKING:
    from hydroservo.cli.progress import Report
    from hydroservo.loop import Loop
    from hydroservo.scenario.build import Argument
    from hydroservo.tuning import Progress

__all__ = ["tune"]

VARY = "--vary"
MOST_CANDIDATES = 10_000_000
MOST_SEEDS = 10_000
LARGEST_SEED = 2**63 - 1
SEARCHED = ("controller", "sensors")  # what a search may set; the rest is given
NO_MATTER = ("out", "threads", "json", "verbose")  # options that change nothing of what is found


def tune(
    context: typer.Context,
    scenarios: Annotated[
        list[str],
        typer.Argument(metavar="SCENARIO", help="Scenario files (TOML) or names of built-in ones."),
    ],
    changes: Changes,
    plugins: Plugins,
    ranges: Annotated[
        list[str],
        typer.Option(
            VARY,
            metavar="PATH=LOW..HIGH",
            default_factory=list,
            show_default=False,
            help="Search a number of the controller or the sensors between two values, such as "
            "0.1..30 V s/m, or relative to that of the first scenario, such as -50%..+100%; evenly in its "
            "logarithm if the range does not hold 0. May be given again.",
        ),
    ],
    metric: Annotated[
        str, typer.Option("--metric", metavar="NAME", help="The metric that is to be small.")
    ] = "rms_error",
    weights: Annotated[
        str,
        typer.Option(
            "--weights",
            metavar="W,W,...",
            show_default="all 1",
            help="Weight of each scenario in the geometric mean of their metrics.",
        ),
    ] = "",
    seeds: Annotated[
        int,
        typer.Option(
            "--seeds",
            metavar="N",
            help="Seeds over which each scenario's metric is averaged, from its own on.",
        ),
    ] = 1,
    effort: Annotated[
        float,
        typer.Option(
            "--effort",
            metavar="E",
            help="Multiply each metric by the E-th power of the command's total variation: with 0.1, one "
            "a tenth as lively is worth a fifth of the metric.",
        ),
    ] = 0.0,
    scales: Annotated[
        str,
        typer.Option(
            "--scales",
            metavar="S,S,...",
            show_default="that of each",
            help="Take each scenario at several scales of its uncertainty, such as -1,0,1, for values that "
            "serve all these machines.",
        ),
    ] = "",
    candidates: Annotated[
        int,
        typer.Option(
            "--candidates",
            metavar="N",
            help="How many sets of values to try; rounded up to a multiple of 64.",
        ),
    ] = 4096,
    seed: Annotated[
        int, typer.Option("--seed", metavar="S", help="Seed of the search, a whole number from 0 on.")
    ] = 0,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE",
            dir_okay=False,
            help="Write the values found as TOML tables to paste into a scenario.",
        ),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option("--threads", metavar="N", min=1, show_default="all cores", help="How many to use."),
    ] = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Search the numbers of one or more scenarios that make a metric smallest.

    Several scenarios are tuned together, for one set of values that serves all: what is made small is the
    geometric mean of their metrics. A run that diverges is worse than any that does not. The same seed finds
    the same values again; another one may find better ones.

    Examples:

    - `hydroservo tune rig/1khz-pi-sine --vary controller.proportional_gain=0.3..30 --vary
      controller.integral_gain=10..5000`
    - `hydroservo tune rig/1khz-pi-sine rig/1khz-pi-square --weights 1,8 --vary
      "controller.proportional_gain=0.3..30 V s/m" --vary "controller.integral_gain=10..5000 V/m" --out
      gains.toml`
    - `hydroservo tune rig/noisy-1khz-pi-sine --seeds 20 --metric max_error --vary
      controller.proportional_gain=-50%..+100%`
    """
    from hydroservo.cli.kernels import log_kernels
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.tune_tables import as_tables, show_tuned, write_values
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.results import as_json
    from hydroservo.tuning import Aim, tune

    check(metric, candidates, seeds, seed, ranges)
    factors = checked_scales(scales)
    loops = [machine(scenario, changes, plugins, scale) for scenario in scenarios for scale in factors]
    check_scales(scales, loops, len(factors))
    each = [weight for weight in checked_weights(weights, len(scenarios)) for _ in factors]
    aim = Aim(loops, each, metric, seeds, effort)
    names = scenarios
    scenarios = [named(name, scale) for name in names for scale in factors]
    arguments = [constructed(scenario, changes, plugins) for scenario in names]
    wanted = searched(ranges, scenarios, loops, arguments)
    if out:
        try_outputs([out])
    with log_kernels(verbose), progress_bar("preparing") as report:
        progress = told(report, metric, candidates)
        found = tune(aim, wanted, candidates=candidates, seed=seed, threads=threads, progress=progress)
    for scenario, table in zip(scenarios, found.tables, strict=True):
        say_remarks(scenario, table)
    command = typed(context)
    name = out.name if out else ""
    left = write_or_keep(out and out.parent, lambda place: [write_values(place / name, command, found)])
    if json:
        typer.echo(as_json(as_tables(scenarios, command, aim, found)))
        left.check()
        return
    show_tuned(scenarios, aim, wanted, found)
    one = " and the first seed" if seeds > 1 else ""
    typer.echo(f"with these values{one}: {replay(names, changes, plugins, found.parameters)}")
    if left.files:
        typer.echo(f"written: {out}")
    left.check()


def check(metric: str, candidates: int, seeds: int, seed: int, ranges: Sequence[str]) -> None:
    """Refuse what nothing can be searched with.

    Raises:
        HydroservoError: in one line, what is wrong and what is allowed.
    """
    from hydroservo.errors import HydroservoError, ParameterError
    from hydroservo.metrics import SMALLER_IS_BETTER
    from hydroservo.nearest import one_of

    limits = (
        ("--candidates", candidates, 1, MOST_CANDIDATES),
        ("--seeds", seeds, 1, MOST_SEEDS),
        ("--seed", seed, 0, LARGEST_SEED),
    )
    for option, value, least, most in limits:
        if not least <= value <= most:
            raise ParameterError(option, value, f"must be a whole number from {least} to {most}")
    if metric not in SMALLER_IS_BETTER:
        raise ParameterError("--metric", metric, one_of(metric, SMALLER_IS_BETTER))
    if not ranges:
        raise HydroservoError(f"nothing to search: give {VARY} PATH=LOW..HIGH")


def checked_weights(text: str, count: int) -> Sequence[float]:
    """One weight for each scenario.

    Raises:
        ParameterError: the text is not that.
    """
    from hydroservo.errors import ParameterError

    if not text:
        return [1.0] * count
    weights = numbers(text)
    if len(weights) != count or not all(0.0 < weight < float("inf") for weight in weights):
        wanted = "must be a number above 0 for each scenario, with commas between them"
        raise ParameterError("--weights", text, f"{wanted}; there are {count}" if count > 1 else wanted)
    return weights


def numbers(text: str) -> list[float]:
    """Numbers with commas between them; one that is none for a text that is not that."""
    try:
        return [float(part) for part in text.split(",")] if text else []
    except ValueError:
        return [math.nan]


def checked_scales(text: str) -> Sequence[float | None]:
    """The scales of uncertainty; None for that of a scenario itself.

    Raises:
        ParameterError: the text is not that.
    """
    from hydroservo.errors import ParameterError

    scales = numbers(text)
    if not all(map(math.isfinite, scales)) or len(set(scales)) < len(scales):
        raise ParameterError("--scales", text, "must be different numbers with commas between them")
    return scales or [None]


def check_scales(text: str, loops: "Sequence[Loop]", count: int) -> None:
    """Refuse scales that make no difference.

    Raises:
        ParameterError: a scenario is the same machine at each of them.
    """
    from hydroservo.errors import ParameterError
    from hydroservo.provenance import scenario_hash

    for start in range(0, len(loops), count):
        if len({scenario_hash(loop) for loop in loops[start : start + count]}) < count:
            raise ParameterError("--scales", text, "changes nothing in a scenario without [uncertainty]")


def machine(scenario: str, changes: Sequence[str], plugins: Sequence[Path], scale: float | None) -> "Loop":
    """A scenario's loop at a scale of its uncertainty; at its own if that is None."""
    return loaded(scenario, [*changes, *([] if scale is None else [f"uncertainty.scale={scale!r}"])], plugins)


def named(scenario: str, scale: float | None) -> str:
    return scenario if scale is None else f"{scenario}, scale {scale:g}"


def constructed(scenario: str, changes: Sequence[str], plugins: Sequence[Path]) -> "Mapping[str, Argument]":
    """What the constructors of a scenario take."""
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.load import assembled

    return assembled(scenario, dict(map(parse_override, changes)), plugins).arguments


def searched(
    ranges: Sequence[str],
    scenarios: Sequence[str],
    loops: "Sequence[Loop]",
    arguments: "Sequence[Mapping[str, Argument]]",
) -> dict[str, tuple[float, float]]:
    """What --vary asks for, in SI units by path.

    Raises:
        ScenarioError: in one line, the path, the value and what is allowed.
    """
    from hydroservo.block import leaves
    from hydroservo.cli.variations import variations
    from hydroservo.errors import ScenarioError

    found = variations(ranges, loops[0], loops[0], arguments[0])
    wanted = {one.path: (one.low, one.high) for one in found}
    for path in wanted:
        if path.partition(".")[0] not in SEARCHED:
            problem = f"must be in the {' or '.join(SEARCHED)}, which a search may choose"
            raise ScenarioError(VARY, path, problem)
        if any(path in own for own in arguments):
            problem = "is what a constructor takes; a search sets numbers of the block that it makes"
            raise ScenarioError(VARY, path, problem)
        for scenario, loop in zip(scenarios, loops, strict=True):
            if path not in dict(leaves(loop)):
                raise ScenarioError(VARY, path, f"is no number of {scenario}")
    return wanted


def told(report: "Report", metric: str, candidates: int) -> "Progress":
    """Reports how many candidates are done, and the best so far."""
    from hydroservo.metrics import METRIC_FIELDS
    from hydroservo.readable import quantity

    def progress(fraction: float, best: float) -> None:
        text = quantity(best, METRIC_FIELDS[metric].unit) if best < float("inf") else "diverged"
        report(fraction, f"{round(fraction * candidates):,} of {candidates:,} candidates, best {text}")

    return progress


def typed(context: typer.Context) -> list[str]:
    """The command that finds the same values again: its start, then each option, quoted for a shell."""
    parts = [["hydroservo", "tune"]]
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        if name in NO_MATTER or source is None or source.name != "COMMANDLINE":
            continue
        value = context.params[name]
        values = [str(one) for one in (value if isinstance(value, list) else [value])]
        if parameter.param_type_name == "argument":
            parts[0] += values
        else:
            parts += [[parameter.opts[0], one] for one in values]
    return [shlex.join(part) for part in parts]


def replay(
    scenarios: Sequence[str],
    changes: Sequence[str],
    plugins: Sequence[Path],
    parameters: Mapping[str, float],
) -> str:
    """The command that simulates the scenarios with the values found."""
    from hydroservo.scenario import parse_override

    kept = [change for change in changes if parse_override(change)[0] not in parameters]
    words = ["hydroservo", "run" if len(scenarios) == 1 else "compare", *scenarios]
    for change in (*kept, *(f"{path}={value!r}" for path, value in parameters.items())):
        words += ["--set", change]
    for plugin in plugins:
        words += ["--plugin", str(plugin)]
    return shlex.join(words)
