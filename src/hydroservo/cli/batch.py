"""The command that runs one scenario many times."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.options import (
    Changes,
    DecimalComma,
    FigureFormat,
    FigureSize,
    Json,
    Plugins,
    Scenario,
    Strict,
    Threads,
    Verbose,
    check_one_place,
    checked_decimal_comma,
    ranges_in,
    replay,
    varied,
)
from hydroservo.cli.places import WHERE
from hydroservo.cli.remarks import say_remarks, say_sizes
from hydroservo.runs.results import FORMATS

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.cli.batch_summary import BatchSummary
    from hydroservo.cli.progress import Report
    from hydroservo.loop import Loop
    from hydroservo.reports.journal import Journal
    from hydroservo.reports.report import Report as Page
    from hydroservo.scenario.parts import Sampled, Workers

USUAL_METRIC = "steady_rms_error"
LARGE_TABLE = 2**28  # bytes; a larger table is announced before the run


def batch(
    context: typer.Context,
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    runs: Annotated[int, typer.Option("--runs", metavar="N", show_default=False, help="How many runs.")],
    ranges: Annotated[
        list[str],
        varied(
            "Draw a number of the scenario, a block's or a datasheet constructor's, evenly between "
            "two values, such as 500..900 MPa, or relative to the value it has, such as -30%..+30% or "
            "x0.5..x2. Of the machine (plant, valve, supply, load) only the truth varies; the controller "
            "goes on believing in the scenario's values."
        ),
    ],
    out: Annotated[
        list[str],
        typer.Option(
            "--out",
            metavar="FILE|DIR",
            default_factory=list,
            show_default=False,
            help=f"Write the parameters and metrics of each run ({', '.join(FORMATS)}), or a picture of "
            "them (.png, .svg, .pdf). May be given again. Into a folder any number of runs go part by part "
            "(Parquet), and the same command goes on where it was stopped; a report goes there too. "
            f"{WHERE}",
        ),
    ],
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    seeds: Annotated[
        bool, typer.Option("--seeds", help="Give each run random numbers of its own, as for sensor noise.")
    ] = False,
    seed: Annotated[
        int, typer.Option("--seed", metavar="S", help="Seed of what --vary draws, a whole number >= 0.")
    ] = 0,
    metric: Annotated[
        str | None,
        typer.Option(
            "--metric",
            metavar="NAME",
            show_default=USUAL_METRIC,
            help="The metric of a picture, and of the worst run.",
        ),
    ] = None,
    threads: Threads = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            metavar="N",
            min=1,
            show_default="threads alone",
            help="Compute the parts of a folder in this many processes, one thread each by default.",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            metavar="ADDRESS",
            show_default="this machine",
            help="Have the workers of a Dask scheduler compute the parts of a folder: tcp://head:8786.",
        ),
    ] = None,
    cuda: Annotated[
        bool, typer.Option("--cuda", help="Compute on a CUDA device, one thread per run.")
    ] = False,
    strict: Strict = False,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Simulate one scenario many times with varied parameters, and print how its metrics are spread.

    Run i has the same parameters whatever the number of runs. The table of --out has them by path, so that
    each run can be replayed alone, with its trajectory: --set gives the machine what was drawn as its truth,
    as `truth.plant.mass=6.5kg`. Metrics of a loop that chatters come out the same alone only with --strict.
    A folder gets a report besides (report.html, its tables as CSV and LaTeX in tables), a picture of the
    metric (spread.png, spread.svg) and how the metrics are spread (metrics.json).

    Examples:

    - `hydroservo batch paper/sine-tsmc --runs 1000 --vary plant.bulk_modulus=-30%..+30%`
    - `hydroservo batch paper/sine-pi --runs 300 --vary plant.mass=4..8kg --out runs.csv --out runs.png`
    - `hydroservo batch paper/sine-tsmc --runs 100 --seeds --set sensors.type=NoisySensors
      --set sensors.velocity_noise="0.5 mm/s" --set sensors.load_force_noise="5 N" --json`
    - `hydroservo batch paper/sine-pi --runs 1000000 --vary plant.mass=4..8kg --out runs
      --scheduler tcp://head:8786`
    """
    from hydroservo.cli.batch_files import destinations, is_csv, write_batch
    from hydroservo.cli.batch_summary import batch_summary, show_batch
    from hydroservo.cli.kernels import log_kernels
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.summary import for_table
    from hydroservo.cli.writing import both, write_or_keep
    from hydroservo.errors import HydroservoError
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.load import assembled
    from hydroservo.scenario.parts import Sampled
    from hydroservo.scenario.sampling import variations

    if not (ranges or seeds):
        raise HydroservoError("nothing varies: give --vary PATH=LOW..HIGH, or --seeds, or both")
    files, folder = destinations(out)
    journal = journal_of(
        figure_format,
        figure_size,
        folder,
        checked_decimal_comma(decimal_comma, folder, *filter(is_csv, files)),
    )
    check_sizes(runs, seed, folder)
    check_workers(workers, scheduler, folder, cuda)
    assembly = assembled(scenario, dict(map(parse_override, changes)), plugins)
    metric = metric_of(assembly.loop, metric, scenario)
    sampled = Sampled(assembly, variations(assembly, ranges_in(ranges)), seed, seeds, strict, cuda)
    announce(scenario, sampled, runs, (files, folder), journal)
    with log_kernels(verbose), progress_bar("preparing") as report:
        start = time.monotonic()
        if folder is None:
            table, computed = in_memory(sampled, runs, threads, report), runs
        else:
            who = workers_of(workers, scheduler, threads)
            table, computed = in_folder(sampled, runs, folder, who, report)
        seconds = time.monotonic() - start
        report(1.0, "writing files")
        varying = [one.path for one in sampled.varied]
        left = write_batch(files, table, varying, metric, decimal_comma)
        summary = batch_summary(scenario, seed, table, sampled.ranges(runs), sampled.varied)
        other_demands = any(path.startswith("reference.") for path in varying)
        shown = summary if other_demands else for_table(summary, assembly.loop)
        alone = run_alone(sampled, table, metric, (scenario, changes, plugins))
        page = partial(page_of, context, shown, table, (metric, varying), alone)
        write = partial(write_page, page, summary.as_tables(), journal)
        left = both(left, write_or_keep(folder, write)._replace(files=()))
    say_remarks(scenario, table)
    if json:
        typer.echo(as_json(summary.as_tables()))
        left.check()
        return
    show_batch(shown, table, seconds, computed)
    typer.echo(alone)
    say_places([*map(str, left.files), *([f"{folder}/"] if folder else [])])
    left.check()


def say_places(places: Sequence[str]) -> None:
    """Where the table, pictures and parts of a batch are."""
    if places:
        typer.echo(f"written: {', '.join(places)}")


def page_of(
    context: typer.Context,
    shown: "BatchSummary",
    table: "xr.Dataset",
    pictured: tuple[str, list[str]],
    alone: str,
) -> "Page":
    """The report, of the summary that is shown, the table of all runs, and what is pictured of it."""
    from hydroservo.cli.reporting import again
    from hydroservo.cli.reports.batch import batch_report

    return batch_report(again(context), shown, table, pictured, alone)


def write_page(
    page: "Callable[[], Page]", said: Mapping[str, Any], journal: "Journal", place: Path
) -> list[Path]:
    """Write the report and the numbers into the folder of a batch; returns what was written."""
    from hydroservo.cli.files import write_results

    return write_results(place, {}, page(), said, journal)


def run_alone(
    sampled: "Sampled", table: "xr.Dataset", metric: str, given: tuple[str, list[str], list[Path]]
) -> str:
    """Which run one would look at first, and the command that runs it alone.

    Args:
        sampled: the batch.
        table: of all runs.
        metric: whose worst run that is.
        given: scenario, changes and plug-ins.
    """
    from hydroservo.cli.batch_summary import remarkable_run

    scenario, changes, plugins = given
    run, reason = remarkable_run(table, metric)
    steps = {"simulation.substeps": table.attrs["substeps"]} if "substeps" in table.attrs else {}
    words = ["hydroservo", "run", scenario, *(["--strict"] if sampled.strict else [])]
    drawn = sampled.drawn(run, 1).changes(0)
    return f"run {run} {reason}; alone: {replay(words, changes, plugins, steps | drawn)}"


def in_memory(sampled: "Sampled", runs: int, threads: int | None, report: "Report") -> "xr.Dataset":
    """The table of a batch."""
    from hydroservo.cli.progress import paced
    from hydroservo.runs.batch import simulate_batch
    from hydroservo.scenario.batch_table import table_of_runs

    drawn = sampled.drawn(0, runs)
    found = simulate_batch(
        sampled.assembly.loop,
        drawn.parameters,
        strict=sampled.strict,
        threads=threads,
        cuda=sampled.cuda,
        progress=paced(report, runs),
    )
    return table_of_runs(found, drawn, sampled.seed, sampled.assembly.arguments)


def in_folder(
    sampled: "Sampled", runs: int, folder: Path, workers: "Workers", report: "Report"
) -> "tuple[xr.Dataset, int]":
    """The table of a batch in a folder, and how many of its runs were computed now."""
    from hydroservo.cli.interrupts import heard
    from hydroservo.cli.progress import paced
    from hydroservo.scenario.parts import MANIFEST, simulate_in_parts

    def say(line: str) -> None:
        typer.echo(f"hydroservo: {line}", err=True)

    try:
        progress = paced(report, runs)
        return simulate_in_parts(sampled, runs, folder, workers=workers, progress=progress, say=say)
    except KeyboardInterrupt:
        begun = (folder / MANIFEST).exists()
        heard(f"; what is done is in {folder}, and the same command goes on from there" if begun else "")
        raise


def check_workers(workers: int | None, scheduler: str | None, folder: Path | None, cuda: bool) -> None:
    """Refuse workers where there is no folder, those of two places, and a device that this machine has not.

    Raises:
        HydroservoError: they are asked for.
    """
    from hydroservo.engine.cuda_driver import device
    from hydroservo.errors import HydroservoError

    if folder is None and (workers or scheduler):
        raise HydroservoError("--workers and --scheduler compute the parts of a folder: give --out DIR")
    check_one_place(workers, scheduler)
    if cuda and scheduler is None:
        device()


def workers_of(workers: int | None, scheduler: str | None, threads: int | None) -> "Workers":
    """Who computes the parts of a folder: all threads of this process, unless there are others."""
    from hydroservo.scenario.parts import Workers

    own = threads if workers is None and scheduler is None else threads or 1
    return Workers(workers or 1, scheduler, own)


def check_sizes(runs: int, seed: int, folder: Path | None) -> None:
    """Refuse a number of runs or a seed out of its range.

    Raises:
        ParameterError: one is.
    """
    from hydroservo.scenario.parts import MOST_IN_PARTS
    from hydroservo.scenario.sampling import MOST, check_size

    check_size(runs, seed, "--", MOST if folder is None else MOST_IN_PARTS)


def columns_of(sampled: "Sampled") -> int:
    """How many columns the table of a batch has, about."""
    from hydroservo.metrics import declared_metrics, monitors_of

    return len(declared_metrics(monitors_of(sampled.assembly.loop))) + 2 * (
        len(sampled.varied) + sampled.seeds
    )


def metric_of(loop: "Loop", metric: str | None, scenario: str) -> str:
    """The metric that is asked for; of a loop without the usual one, another, with a line that says so.

    Raises:
        HydroservoError: the loop has no such number; in one line, with those that it has.
    """
    from hydroservo.errors import ParameterError
    from hydroservo.metrics import declared_metrics, default_metric, flags_of, monitors_of
    from hydroservo.nearest import one_of

    watching = monitors_of(loop)
    flags = flags_of(watching)
    numbers = [name for name in declared_metrics(watching) if name not in flags]
    if metric is None:
        metric = default_metric(numbers, USUAL_METRIC)
        if metric != USUAL_METRIC:
            text = f"the loop has no {USUAL_METRIC}; {metric} is shown, and --metric takes another"
            typer.echo(f"{scenario}: {text}", err=True)
    if metric not in numbers:
        raise ParameterError("--metric", metric, one_of(metric, numbers))
    return metric


def announce(
    scenario: str,
    sampled: "Sampled",
    runs: int,
    places: tuple[Sequence[Path], Path | None],
    journal: "Journal",
) -> None:
    """Before the runs: try the files, and say how much memory a large table will take, and odd sizes."""
    from hydroservo.cli.files import result_files
    from hydroservo.cli.writing import try_outputs
    from hydroservo.reports.folder import Files
    from hydroservo.scenario.parts import MANIFEST

    files, folder = places
    size = 8 * runs * columns_of(sampled)
    report = Files(["spread"], ["varied", "metrics"], journal)
    try_outputs([*files, *(result_files(folder, [MANIFEST], report) if folder else [])], size)
    say_sizes(scenario, sampled.assembly.loop)
    if size > LARGE_TABLE and (files or folder is None):
        typer.echo(f"the table of all runs will take {size / 2**20:.0f} MiB of memory", err=True)
