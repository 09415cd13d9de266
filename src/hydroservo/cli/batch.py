"""The command that runs one scenario many times."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.frame import PICTURE_ENDINGS, CommandOutput, Written, with_output
from hydroservo.cli.interrupts import acknowledge_interrupt
from hydroservo.cli.messages import Report, log_kernels, progress_with_rate, warn_of_sizes
from hydroservo.cli.options import (
    Changes,
    Plugins,
    Scenario,
    Strict,
    Threads,
    Verbose,
    check_one_place,
    parse_ranges,
    replay_command,
    vary_option,
)
from hydroservo.core.errors import HydroservoError, ParameterError, one_of, require
from hydroservo.core.outputs import OutputError, keep_elsewhere, staged, write_text
from hydroservo.runs.results import FORMATS, ResultFormat, save
from hydroservo.show.journal import NO_JOURNAL, Journal

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.control.loop import Loop
    from hydroservo.scenario.stored_batch import SampledBatch, Workers
    from hydroservo.show import Finding

PICTURED = 10**7  # runs; the columns of more take up memory that a batch in parts does not need otherwise
LARGE_TABLE = 2**28  # bytes; a larger table is announced before the run
ENDINGS = (*FORMATS, *PICTURE_ENDINGS)


@with_output(
    f"Write the parameters and metrics of each run ({', '.join(FORMATS)}), or a picture of them (.png, .svg, "
    ".pdf). Into a folder any number of runs go part by part (Parquet), and the same command goes on where "
    "it was stopped; a report goes there too.",
    endings=ENDINGS,
    several=True,
)
def batch_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    runs: Annotated[int, typer.Option("--runs", metavar="N", show_default=False, help="How many runs.")],
    ranges: Annotated[
        list[str],
        vary_option(
            "Draw a number of the scenario, a block's or a datasheet constructor's, evenly between "
            "two values, such as 500..900 MPa, or relative to the value it has, such as -30%..+30% or "
            "x0.5..x2. Of the machine (plant, valve, supply, load) only the truth varies; the controller "
            "goes on believing in the scenario's values."
        ),
    ],
    output: CommandOutput,
    seeds: Annotated[
        bool,
        typer.Option("--seeds", help="Give each run its own random numbers, for sensor noise for example."),
    ] = False,
    seed: Annotated[
        int, typer.Option("--seed", metavar="S", help="Seed of what --vary draws, a whole number >= 0.")
    ] = 0,
    metric: Annotated[
        str | None,
        typer.Option(
            "--metric",
            metavar="NAME",
            show_default="steady_rms_error",
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
      --set sensors.velocity_noise="0.5 mm/s" --set sensors.hydraulic_force_noise="5 N" --json`
    - `hydroservo batch paper/sine-pi --runs 1000000 --vary plant.mass=4..8kg --out runs
      --scheduler tcp://head:8786`
    """
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.load import assemble
    from hydroservo.scenario.parameter_draws import variations
    from hydroservo.scenario.stored_batch import SampledBatch

    if not (ranges or seeds):
        raise HydroservoError("nothing varies: give --vary PATH=LOW..HIGH, or --seeds, or both")
    if output.folder or any(file.suffix.lower() == ".parquet" for file in output.files):
        require("pyarrow", "parquet", "Parquet")
    check_sizes(runs, seed, output.folder)
    check_workers(workers, scheduler, output.folder, cuda)
    assembly = assemble(scenario, dict(map(parse_override, changes)), plugins)
    metric = chosen_metric(assembly.loop, metric, scenario)
    sampled = SampledBatch(assembly, variations(assembly, parse_ranges(ranges)), seed, seeds, strict, cuda)
    size = announce_table_size(scenario, sampled, runs, output)

    def ask(report: Report) -> "xr.Dataset":
        start = time.monotonic()
        with log_kernels(verbose):
            if output.folder is None:
                table, computed = compute_in_memory(sampled, runs, threads, report), runs
            else:
                who = workers_of(workers, scheduler, threads)
                table, computed = compute_in_folder(sampled, runs, output.folder, who, report)
        print_speed(runs, computed, time.monotonic() - start)
        return table

    say = partial(describe_batch, sampled, metric, (scenario, changes, plugins))
    write = partial(write_batch_files, output.files, metric=metric, journal=output.journal)
    output.present(scenario, ask, say, size=size, others=other_files(output), write_more=write)


def describe_batch(
    sampled: "SampledBatch", metric: str, given: tuple[str, list[str], list[Path]], table: "xr.Dataset"
) -> "Finding":
    """What a batch says, with the command that runs its most remarkable run alone."""
    from hydroservo.runs.batch_finding import batch_finding
    from hydroservo.scenario.ranges import typed_scales

    typed = typed_scales((one.entry, table[one.path].attrs["units"]) for one in sampled.varied)
    alone = command_of_remarkable_run(sampled, table, metric, given)
    finding = batch_finding(table, given[0], metric=metric, typed=typed, alone=alone)
    if table.sizes["run"] <= PICTURED:
        return finding
    remark = "a picture of so many runs is drawn only with --out FILE.png"
    return finding._replace(pictures=[], remarks=[*finding.remarks, remark])


def print_speed(runs: int, computed: int, seconds: float) -> None:
    """How fast runs were computed, on stderr."""
    there = f"; {runs - computed:,} were there before" if computed < runs else ""
    rate = computed / seconds
    speed = f"{rate:,.0f}" if rate >= 99.5 else f"{rate:.3g}"
    text = f"{seconds:.3g} s, {speed} runs per second, compilation included{there}"
    typer.echo(f"hydroservo: {text if computed else 'all runs were there before'}", err=True)


def command_of_remarkable_run(
    sampled: "SampledBatch", table: "xr.Dataset", metric: str, given: tuple[str, list[str], list[Path]]
) -> str:
    """The command that runs alone the run that one would look at first."""
    from hydroservo.runs.batch_finding import remarkable_run

    scenario, changes, plugins = given
    run, _ = remarkable_run(table, metric)
    steps = {"simulation.substeps": table.attrs["substeps"]} if "substeps" in table.attrs else {}
    words = ["hydroservo", "run", scenario, *(["--strict"] if sampled.strict else [])]
    drawn = sampled.drawn(run, 1).changes(0)
    return replay_command(words, changes, plugins, steps | drawn)


def compute_in_memory(
    sampled: "SampledBatch", runs: int, threads: int | None, report: Report
) -> "xr.Dataset":
    from hydroservo.runs.batch import simulate_batch
    from hydroservo.scenario.stored_batch import table_of_runs

    drawn = sampled.drawn(0, runs)
    found = simulate_batch(
        sampled.assembly.loop,
        drawn.parameters,
        strict=sampled.strict,
        threads=threads,
        cuda=sampled.cuda,
        progress=progress_with_rate(report, runs),
    )
    return table_of_runs(found, drawn, sampled.seed, sampled.assembly.arguments)


def compute_in_folder(
    sampled: "SampledBatch", runs: int, folder: Path, workers: "Workers", report: Report
) -> "tuple[xr.Dataset, int]":
    """The table of a batch in a folder, and how many of its runs were computed now."""
    from hydroservo.scenario.stored_batch import MANIFEST, simulate_in_parts

    def say(line: str) -> None:
        typer.echo(f"hydroservo: {line}", err=True)

    try:
        progress = progress_with_rate(report, runs)
        return simulate_in_parts(sampled, runs, folder, workers=workers, progress=progress, say=say)
    except KeyboardInterrupt:
        begun = (folder / MANIFEST).exists()
        acknowledge_interrupt(
            f"; what is done is in {folder}, and the same command goes on from there" if begun else ""
        )
        raise


def check_workers(workers: int | None, scheduler: str | None, folder: Path | None, cuda: bool) -> None:
    """Refuse workers without a folder, those of two places, and a device that this machine has not."""
    from hydroservo.engine.cuda_driver import device

    if folder is None and (workers or scheduler):
        raise HydroservoError("--workers and --scheduler compute the parts of a folder: give --out DIR")
    check_one_place(workers, scheduler)
    if cuda and scheduler is None:
        device()


def workers_of(workers: int | None, scheduler: str | None, threads: int | None) -> "Workers":
    """Who computes the parts of a folder: all threads of this process, unless there are others."""
    from hydroservo.scenario.stored_batch import Workers

    own = threads if workers is None and scheduler is None else threads or 1
    return Workers(workers or 1, scheduler, own)


def check_sizes(runs: int, seed: int, folder: Path | None) -> None:
    """Refuse a number of runs or a seed out of its range."""
    from hydroservo.scenario.parameter_draws import MOST, check_size
    from hydroservo.scenario.stored_batch import MOST_IN_PARTS

    check_size(runs, seed, "--", MOST if folder is None else MOST_IN_PARTS)


def estimate_columns(sampled: "SampledBatch") -> int:
    """How many columns the table of a batch has, about."""
    from hydroservo.control.metrics import declared_metrics, monitors_of

    return len(declared_metrics(monitors_of(sampled.assembly.loop))) + 2 * (
        len(sampled.varied) + sampled.seeds
    )


def chosen_metric(loop: "Loop", metric: str | None, scenario: str) -> str:
    """The metric that is asked for; of a loop without the usual one, another, with a line that says so."""
    from hydroservo.control.metrics import declared_metrics, default_metric, flags_of, monitors_of
    from hydroservo.runs.batch_finding import USUAL_METRIC

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


def announce_table_size(scenario: str, sampled: "SampledBatch", runs: int, output: CommandOutput) -> int:
    """How much the table of all runs will take [bytes]; a large one, and odd sizes, are said on stderr."""
    size = 8 * runs * estimate_columns(sampled)
    warn_of_sizes(scenario, sampled.assembly.loop)
    if size > LARGE_TABLE and (output.files or output.folder is None):
        typer.echo(f"the table of all runs will take {size / 2**20:.0f} MiB of memory", err=True)
    return size


def other_files(output: CommandOutput) -> list[Path]:
    """The files of a batch besides its report."""
    from hydroservo.scenario.stored_batch import MANIFEST

    return [*output.files, *([output.folder / MANIFEST] if output.folder else [])]


def write_batch_files(
    files: Sequence[Path], table: "xr.Dataset", *, metric: str, journal: Journal = NO_JOURNAL
) -> Written:
    """Write a table, and pictures of one metric against what varied, each whatever becomes of the others."""
    failures: dict[Path, Exception] = {}
    write = partial(write_batch_file, table=table, metric=metric, journal=journal)
    for folder in dict.fromkeys(file.parent for file in files):
        together = [file for file in files if file.parent == folder]
        try:
            with staged(folder) as stage:
                for file in together:
                    try:
                        write(stage / file.name)
                    except Exception as error:  # whatever it is, the other files are worth having
                        failures[file] = error
        except OutputError as error:
            failures |= dict.fromkeys(together, error)
    done = [file for file in files if file not in failures]
    return Written(done, combine_failures(failures, write))


def combine_failures(failures: Mapping[Path, Exception], write: Callable[[Path], object]) -> Exception | None:
    """What a batch ends with: all that could not be written and where it is instead, or what else failed."""
    lost = {file: str(error) for file, error in failures.items() if isinstance(error, OutputError)}
    others = [error for file, error in failures.items() if file not in lost]
    if not lost:
        return others[0] if others else None
    problem = OutputError("; ".join(dict.fromkeys(lost.values())))
    found = keep_elsewhere(problem, lambda place: [write(place / name) for name in distinct_names(lost)])
    if others:
        others[0].add_note(str(found))
    return others[0] if others else found


def distinct_names(files: Iterable[Path]) -> list[str]:
    """The name of each file, with a number before it where another has the same."""
    names = [file.name for file in files]
    return [name if names.count(name) == 1 else f"{i}-{name}" for i, name in enumerate(names, 1)]


def write_batch_file(file: Path, table: "xr.Dataset", metric: str, journal: Journal) -> None:
    ending = file.suffix.lower()
    if ending in FORMATS:
        save(table, file)
        if ending == ResultFormat.CSV.ending:
            write_text(file, journal.csv(file.read_text(encoding="utf-8")))
    else:
        from hydroservo.runs.batch_finding import draw_spread

        draw_spread(table, metric).save(file, origin=table.attrs["hash"])
