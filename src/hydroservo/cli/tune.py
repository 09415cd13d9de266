"""The command that searches gains."""

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.options import Changes, Json, Plugins, loaded

if TYPE_CHECKING:
    from hydroservo.cli.progress import Report
    from hydroservo.tuning import Aim, Progress

__all__ = ["tune"]

MOST_CANDIDATES = 10_000_000
MOST_SEEDS = 10_000


def tune(
    scenarios: Annotated[
        list[str],
        typer.Argument(metavar="SCENARIO", help="Scenario files (TOML) or names of built-in ones."),
    ],
    changes: Changes,
    plugins: Plugins,
    ranges: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="PATH=LOW..HIGH",
            default_factory=list,
            show_default=False,
            help="Search a number of the scenario between two values, such as 0.1..30 V s/m; evenly in its "
            "logarithm if neither is 0. May be given again.",
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
        int, typer.Option("--seeds", metavar="N", help="Seeds over which each scenario's metric is averaged.")
    ] = 1,
    candidates: Annotated[
        int, typer.Option("--candidates", metavar="N", help="How many sets of values to try.")
    ] = 4096,
    seed: Annotated[int, typer.Option("--seed", metavar="S", help="Seed of the search.")] = 0,
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
) -> None:
    """Search the numbers of one or more scenarios that make a metric smallest.

    Several scenarios are tuned together, for one set of values that serves all: what is made small is the
    geometric mean of their metrics. A run that diverges counts as very large. The same seed finds the same
    values again; another one may find better ones.

    Examples:

    - `hydroservo tune paper/sine-pi --vary controller.proportional_gain=0.3..300 --vary
      controller.integral_gain=1..10000 --set valve.type=FirstOrderValve --set "simulation.period=100 us"`
    - `hydroservo tune rig/1khz-pi-sine rig/1khz-pi-square --weights 1,7 --vary
      controller.proportional_gain=0.3..30 --vary controller.integral_gain=10..5000 --out gains.toml`
    """
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.replay import Origin
    from hydroservo.cli.tune_tables import as_tables, show_tuned, write_values
    from hydroservo.cli.variations import variations
    from hydroservo.results import as_json
    from hydroservo.tuning import Aim, tune

    within("--candidates", candidates, MOST_CANDIDATES)
    within("--seeds", seeds, MOST_SEEDS)
    within("--seed", seed, 2**63 - 1, least=0)
    loops = [loaded(scenario, changes, plugins) for scenario in scenarios]
    aim = Aim(loops, checked_weights(weights, len(loops)), metric, seeds)
    nominal = Origin(scenarios[0], changes, plugins).nominal()
    wanted = {one.path: (one.low, one.high) for one in variations(ranges, loops[0], nominal)}
    if not wanted:
        raise_nothing()
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
    with progress_bar("preparing") as report:
        found = tune(
            aim, wanted, candidates=candidates, seed=seed, threads=threads, progress=told(report, aim)
        )
    command = shlex.join(typed(scenarios, changes, plugins, ranges, metric, weights, seeds, candidates, seed))
    if out is not None:
        write_values(out, command, found)
    if json:
        typer.echo(as_json(as_tables(scenarios, command, aim, found)))
        return
    show_tuned(scenarios, aim, wanted, found)
    if out is not None:
        typer.echo(f"written: {out}")


def within(option: str, value: int, most: int, least: int = 1) -> None:
    from hydroservo.errors import ParameterError

    if not least <= value <= most:
        raise ParameterError(option, value, f"must be a whole number from {least} to {most}")


def raise_nothing() -> None:
    from hydroservo.errors import HydroservoError

    raise HydroservoError("nothing to search: give --vary PATH=LOW..HIGH")


def checked_weights(text: str, count: int) -> Sequence[float]:
    """One weight for each scenario.

    Raises:
        ParameterError: the text is not that.
    """
    from hydroservo.errors import ParameterError

    if not text:
        return [1.0] * count
    try:
        weights = [float(part) for part in text.split(",")]
    except ValueError:
        weights = []
    if len(weights) != count or not all(0.0 < weight < float("inf") for weight in weights):
        raise ParameterError("--weights", text, f"must be {count} numbers above 0, with commas between them")
    return weights


def told(report: "Report", aim: "Aim") -> "Progress":
    """Shows the best that was found so far."""
    from hydroservo.metrics import METRIC_FIELDS
    from hydroservo.readable import quantity

    def progress(fraction: float, best: float) -> None:
        report(fraction, f"best so far {quantity(best, METRIC_FIELDS[aim.metric].unit)}")

    return progress


def typed(
    scenarios: Sequence[str],
    changes: Sequence[str],
    plugins: Sequence[Path],
    ranges: Sequence[str],
    metric: str,
    weights: str,
    seeds: int,
    candidates: int,
    seed: int,
) -> Sequence[str]:
    """The command that finds the same values again, word by word."""
    options: Mapping[str, object] = {
        "--metric": metric,
        "--weights": weights,
        "--seeds": seeds,
        "--candidates": candidates,
        "--seed": seed,
    }
    defaults = {"--metric": "rms_error", "--weights": "", "--seeds": 1, "--candidates": 4096, "--seed": 0}
    words = ["hydroservo", "tune", *scenarios]
    for option, values in (("--set", changes), ("--plugin", plugins), ("--vary", ranges)):
        words += [word for value in values for word in (option, str(value))]
    for option, value in options.items():
        words += [option, str(value)] if value != defaults[option] else []
    return words
