"""The command that searches gains."""

import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.options import VARY, Changes, Json, Plugins, Verbose, loaded, ranges_in, replay
from hydroservo.cli.remarks import say_remarks

if TYPE_CHECKING:
    from hydroservo.cli.progress import Report
    from hydroservo.loop import Loop
    from hydroservo.scenario.load import Assembly
    from hydroservo.scenario.search import Search
    from hydroservo.tuning import Progress

__all__ = ["tune"]

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
            "logarithm if the range does not hold 0. May be given again. [default: `[tune.vary]`]",
        ),
    ],
    metric: Annotated[
        str | None,
        typer.Option(
            "--metric", metavar="NAME", show_default="rms_error", help="The metric that is to be small."
        ),
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
            help="How many sets of values to try; rounded up to a multiple of 64.",
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            "--seed", metavar="S", show_default="0", help="Seed of the search, a whole number from 0 on."
        ),
    ] = None,
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

    What no option says is as the table `[tune]` of the first scenario says. Several scenarios on the command
    line stand in place of those, and of their weights, in `[tune]`.

    Examples:

    - `hydroservo tune rig/1khz-pi-sine`
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

    options = given_by_options(metric, weights, seeds, effort, scales, candidates, seed)
    search = assembly_of(scenarios[0], changes, plugins).search._replace(**options)
    search = search._replace(**together(scenarios, search, weighed=weights is not None))
    names = list(map(str, search.scenarios))
    assemblies = [assembly_of(name, changes, plugins) for name in names]
    wanted = ranges_for(ranges, search, names, assemblies)
    factors: Sequence[float | None] = search.scales or [None]
    loops = [machine(name, changes, plugins, scale) for name in names for scale in factors]
    unit = unit_of(search.metric, loops)
    check_scales("tune.scales" if scales is None else "--scales", search.scales, loops)
    each = [weight for weight in search.weights for _ in factors]
    aim = Aim(loops, each, search.metric, search.seeds, search.effort)
    scenarios = [named(name, scale) for name in names for scale in factors]
    if out:
        try_outputs([out])
    with log_kernels(verbose), progress_bar("preparing") as report:
        progress = told(report, unit, search.candidates)
        found = tune(
            aim, wanted, candidates=search.candidates, seed=search.seed, threads=threads, progress=progress
        )
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
    one = " and the first seed" if search.seeds > 1 else ""
    again = replay(
        ["hydroservo", "run" if len(names) == 1 else "compare", *names], changes, plugins, found.parameters
    )
    typer.echo(f"with these values{one}: {again}")
    if left.files:
        typer.echo(f"written: {out}")
    left.check()


def given_by_options(
    metric: str | None,
    weights: str | None,
    seeds: int | None,
    effort: float | None,
    scales: str | None,
    candidates: int | None,
    seed: int | None,
) -> dict[str, Any]:
    """What options say of a search, by the key of ``[tune]`` that each overrides.

    Raises:
        ParameterError: in one line, what is wrong and what is allowed.
    """
    from hydroservo.errors import ParameterError
    from hydroservo.scenario.search import READERS

    lists = {"weights": weights, "scales": scales}
    plain = {"metric": metric, "seeds": seeds, "effort": effort, "candidates": candidates, "seed": seed}
    found = {}
    for name, text in (lists | plain).items():
        if text is not None:
            try:
                found[name] = READERS[name](numbers(str(text)) if name in lists else text)
            except ValueError as error:
                commas = ", with commas between them" if name in lists else ""
                raise ParameterError(f"--{name}", text, f"{error}{commas}") from None
    return found


def numbers(text: str) -> list[float]:
    """Numbers with commas between them; one that is none for a text that is not that."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        return [math.nan]


def together(scenarios: Sequence[str], search: "Search", *, weighed: bool) -> dict[str, Any]:
    """The scenarios that are tuned together, and a weight for each.

    Args:
        scenarios: those on the command line.
        search: what is said of the first one's search, by its ``[tune]`` and by options.
        weighed: whether an option gives the weights.

    Raises:
        HydroservoError: the scenarios in ``[tune]`` are others, or there are more or fewer weights.
    """
    from hydroservo.errors import HydroservoError, ParameterError
    from hydroservo.scenario.catalogue import same_place

    names: Sequence[str | Path] = scenarios
    weights = search.weights if weighed or len(scenarios) == 1 else ()
    if len(scenarios) == 1 and search.scenarios:
        names = search.scenarios
        if same_place(scenarios[0]) not in map(same_place, names):
            others = ", ".join(map(str, names))
            raise HydroservoError(
                f"{scenarios[0]}: tune.scenarios: must hold the scenario itself; they are {others}"
            )
    if weights and len(weights) != len(names):
        text = ",".join(f"{weight:g}" for weight in weights)
        problem = (
            f"must be a number above 0 for each scenario, with commas between them; there are {len(names)}"
        )
        raise ParameterError("--weights", text, problem)
    return {"scenarios": names, "weights": weights or [1.0] * len(names)}


def check_scales(name: str, scales: Sequence[float], loops: "Sequence[Loop]") -> None:
    """Refuse scales that make no difference.

    Args:
        name: what gives them.
        scales: of the uncertainty; none for each scenario's own.
        loops: those of each scenario, scale by scale.

    Raises:
        ParameterError: a scenario is the same machine at each of them.
    """
    from hydroservo.errors import ParameterError
    from hydroservo.provenance import scenario_hash

    count = len(scales) or 1
    for start in range(0, len(loops), count):
        if len({scenario_hash(loop) for loop in loops[start : start + count]}) < count:
            text = ",".join(f"{scale:g}" for scale in scales)
            raise ParameterError(name, text, "changes nothing in a scenario without [uncertainty]")


def machine(scenario: str, changes: Sequence[str], plugins: Sequence[Path], scale: float | None) -> "Loop":
    """A scenario's loop at a scale of its uncertainty; at its own if that is None."""
    return loaded(scenario, [*changes, *([] if scale is None else [f"uncertainty.scale={scale!r}"])], plugins)


def named(scenario: str, scale: float | None) -> str:
    return scenario if scale is None else f"{scenario}, scale {scale:g}"


def assembly_of(scenario: str, changes: Sequence[str], plugins: Sequence[Path]) -> "Assembly":
    """A scenario, and what it is made of."""
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.load import assembled

    return assembled(scenario, dict(map(parse_override, changes)), plugins)


def ranges_for(
    texts: Sequence[str], search: "Search", names: Sequence[str], assemblies: "Sequence[Assembly]"
) -> dict[str, tuple[float, float]]:
    """Between what each number is searched, in SI units by path: what --vary says, else what ``[tune]`` says.

    Raises:
        HydroservoError: in one line, the path, the value and what is allowed.
    """
    from hydroservo.block import leaves
    from hydroservo.errors import HydroservoError, ScenarioError
    from hydroservo.scenario.search import searched_range

    first = assemblies[0]
    options = ranges_in(texts)
    wanted = {
        path: searched_range(path, entry, first.loop, first.arguments) for path, entry in options.items()
    }
    wanted = wanted or dict(search.ranges)
    if not wanted:
        raise HydroservoError(f"nothing to search: give {VARY} PATH=LOW..HIGH, or the scenario [tune.vary]")
    for path, one in wanted.items():
        for name, assembly in zip(names, assemblies, strict=True):
            if path not in dict(leaves(assembly.loop)) or path in assembly.arguments:
                raise ScenarioError(one.entry.origin.name, one.entry.key, f"is no number of {name}")
    return {path: (one.low, one.high) for path, one in wanted.items()}


def unit_of(metric: str, loops: "Sequence[Loop]") -> str:
    """The unit of a metric that all loops have.

    Raises:
        ParameterError: one does not have it.
    """
    from hydroservo.errors import ParameterError
    from hydroservo.metrics import judged_by
    from hydroservo.nearest import one_of

    known = judged_by(loops)
    if metric not in known:
        raise ParameterError("--metric", metric, one_of(metric, known))
    return known[metric].unit


def told(report: "Report", unit: str, candidates: int) -> "Progress":
    """Reports how many candidates are done, and the best so far."""
    from hydroservo.readable import quantity

    def progress(fraction: float, best: float) -> None:
        text = quantity(best, unit) if best < float("inf") else "diverged"
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
