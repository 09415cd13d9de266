"""The command that runs one scenario many times."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.options import VARY, Changes, Json, Plugins, Scenario, Strict, Verbose, ranges_in, replay
from hydroservo.cli.remarks import say_remarks
from hydroservo.runs.results import FORMATS

if TYPE_CHECKING:
    from hydroservo.cli.progress import Report
    from hydroservo.loop import Loop
    from hydroservo.runs.run import Progress

__all__ = ["batch"]

LARGE_TABLE = 2**28  # bytes; a larger table is announced before the run
PAUSE = 1.0  # s, before which a rate would be a guess


def batch(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    runs: Annotated[int, typer.Option("--runs", metavar="N", show_default=False, help="How many runs.")],
    ranges: Annotated[
        list[str],
        typer.Option(
            VARY,
            metavar="PATH=LOW..HIGH",
            default_factory=list,
            show_default=False,
            help="Draw a number of the scenario, a block's or a datasheet constructor's, evenly between "
            "two values, such as 500..900 MPa, or relative to the value it has, such as -30%..+30%. Of the "
            "machine (plant, valve, supply, load) only the truth varies; the controller goes on believing in "
            "the scenario's values. May be given again.",
        ),
    ],
    out: Annotated[
        list[Path],
        typer.Option(
            "--out",
            metavar="FILE",
            default_factory=list,
            show_default=False,
            dir_okay=False,
            help=f"Write the parameters and metrics of each run ({', '.join(FORMATS)}), or a picture of "
            "them (.png, .svg, .pdf). May be given again.",
        ),
    ],
    seeds: Annotated[
        bool, typer.Option("--seeds", help="Give each run random numbers of its own, as for sensor noise.")
    ] = False,
    seed: Annotated[
        int, typer.Option("--seed", metavar="S", help="Seed of what --vary draws, a whole number from 0 on.")
    ] = 0,
    metric: Annotated[
        str, typer.Option("--metric", metavar="NAME", help="The metric of a picture, and of the worst run.")
    ] = "steady_rms_error",
    threads: Annotated[
        int | None,
        typer.Option("--threads", metavar="N", min=1, show_default="all cores", help="How many to use."),
    ] = None,
    strict: Strict = False,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Simulate one scenario many times with varied parameters, and print how its metrics are spread.

    Run i has the same parameters whatever the number of runs. The table of --out has them by path, so that
    each run can be replayed alone, with its trajectory: --set gives the machine what was drawn as its truth,
    as `truth.plant.mass=6.5kg`.

    Examples:

    - `hydroservo batch paper/sine-tsmc --runs 1000 --vary plant.bulk_modulus=-30%..+30%`
    - `hydroservo batch paper/sine-pi --runs 300 --vary plant.mass=4..8kg --out runs.csv --out runs.png`
    - `hydroservo batch paper/sine-tsmc --runs 100 --seeds --set sensors.type=NoisySensors
      --set sensors.velocity_noise="0.5 mm/s" --set sensors.load_force_noise="5 N" --json`
    """
    from hydroservo.cli.batch_files import checked_endings, table_of_runs, write_batch
    from hydroservo.cli.batch_summary import batch_summary, remarkable_run, show_batch
    from hydroservo.cli.kernels import log_kernels
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.summary import for_table
    from hydroservo.errors import HydroservoError
    from hydroservo.metrics import declared_metrics, monitors_of
    from hydroservo.runs.batch import simulate_batch
    from hydroservo.runs.results import as_json
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.load import assembled
    from hydroservo.scenario.sampling import check_size, draws_of, variations

    check_size(runs, seed, "--")
    if not (ranges or seeds):
        raise HydroservoError("nothing varies: give --vary PATH=LOW..HIGH, or --seeds, or both")
    checked_endings(out)
    assembly = assembled(scenario, dict(map(parse_override, changes)), plugins)
    loop = assembly.loop
    check_metric(metric, loop)
    varied = variations(assembly, ranges_in(ranges))
    announce(out, runs, len(declared_metrics(monitors_of(loop))) + 2 * (len(varied) + seeds))
    with log_kernels(verbose), progress_bar("preparing") as report:
        start = time.monotonic()
        drawn = draws_of(assembly, varied, runs, seed=seed, seeds=seeds)
        found = simulate_batch(
            loop, drawn.parameters, strict=strict, threads=threads, progress=paced(report, runs)
        )
        seconds = time.monotonic() - start
        table = table_of_runs(found, drawn, seed, assembly.arguments)
        report(1.0, "writing files")
        left = write_batch(out, table, [one.path for one in varied], metric)
    summary = batch_summary(scenario, seed, table, drawn.ranges)
    say_remarks(scenario, table)
    if json:
        typer.echo(as_json(summary.as_tables()))
        left.check()
        return
    meant = not any(one.path.startswith("reference.") for one in varied)
    show_batch(for_table(summary, loop) if meant else summary, table, seconds)
    run, reason = remarkable_run(table, metric)
    steps = {"simulation.substeps": table.attrs["substeps"]} if "substeps" in table.attrs else {}
    words = ["hydroservo", "run", scenario, *(["--strict"] if strict else [])]
    typer.echo(f"run {run} {reason}; alone: {replay(words, changes, plugins, steps | drawn.changes(run))}")
    if left.files:
        typer.echo(f"written: {', '.join(map(str, left.files))}")
    left.check()


def check_metric(metric: str, loop: "Loop") -> None:
    """Refuse what is no number among the metrics of a loop.

    Raises:
        HydroservoError: in one line, what is wrong and what is allowed.
    """
    from hydroservo.errors import ParameterError
    from hydroservo.metrics import declared_metrics, flags_of, monitors_of
    from hydroservo.nearest import one_of

    watching = monitors_of(loop)
    flags = flags_of(watching)
    numbers = [name for name in declared_metrics(watching) if name not in flags]
    if metric not in numbers:
        raise ParameterError("--metric", metric, one_of(metric, numbers))


def announce(files: Sequence[Path], runs: int, columns: int) -> None:
    """Before the runs: try the files, and say how much memory a large table will take."""
    from hydroservo.cli.writing import try_outputs

    size = 8 * runs * columns
    try_outputs(files, size)
    if size > LARGE_TABLE:
        typer.echo(f"the table of all runs will take {size / 2**20:.0f} MiB of memory", err=True)


def paced(report: "Report", runs: int) -> "Progress":
    """Reports how many runs are done, how many a second, and how long the others will take."""
    first: tuple[float, float] | None = None  # the clock and the fraction at the first report

    def progress(fraction: float) -> None:
        nonlocal first
        now = time.monotonic()
        first = first or (now, fraction)
        seconds, done = now - first[0], fraction - first[1]
        text = f"{round(fraction * runs):,} of {runs:,} runs"
        if seconds > PAUSE and done > 0.0:
            left = round((1.0 - fraction) * seconds / done)
            text += f", {done * runs / seconds:,.0f} a second, {left // 60}:{left % 60:02d} left"
        report(fraction, text)

    return progress
