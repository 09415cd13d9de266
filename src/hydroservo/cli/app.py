"""The commands: what each takes, and in which order it calls the library."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo._version import __version__
from hydroservo.cli.audit import audit
from hydroservo.cli.batch import batch
from hydroservo.cli.bode import bode
from hydroservo.cli.check import check
from hydroservo.cli.completion import scenarios_like, studies_like
from hydroservo.cli.describe import describe, schema
from hydroservo.cli.differences import unequal_lines
from hydroservo.cli.export import export_app
from hydroservo.cli.failures import Commands, Listing, naming
from hydroservo.cli.identify import identify
from hydroservo.cli.limit import limit
from hydroservo.cli.linearize import linearize
from hydroservo.cli.log import log
from hydroservo.cli.map import map_logs
from hydroservo.cli.options import (
    Changes,
    DecimalComma,
    FigureFormat,
    FigureSize,
    Folder,
    Json,
    Plugins,
    Scenario,
    Several,
    Strict,
    Verbose,
    checked_decimal_comma,
    loaded,
)
from hydroservo.cli.page import page
from hydroservo.cli.places import WHERE, folder_at
from hydroservo.cli.remarks import say_remarks
from hydroservo.cli.study import study
from hydroservo.cli.tune import tune
from hydroservo.runs.results import Format

if TYPE_CHECKING:
    from hydroservo.cli.progress import Report
    from hydroservo.loop import Loop

NOTHING: tuple[str, ...] = ()  # no trajectory is kept where nothing will be written
LARGE_TRACE = 2**28  # bytes; a larger trajectory is announced before the run

app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)
scenarios_app = typer.Typer(cls=Listing, rich_markup_mode="markdown")
app.add_typer(scenarios_app, name="scenarios")
studies_app = typer.Typer(cls=Listing, rich_markup_mode="markdown")
app.add_typer(studies_app, name="studies")
app.add_typer(export_app, name="export")


def print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"hydroservo {__version__}")
        raise typer.Exit


@app.callback()
def about(
    version: Annotated[
        bool,
        typer.Option("--version", callback=print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Simulate servo-hydraulic axes, and tune, compare and export their controllers.

    Start with `hydroservo scenarios` and `hydroservo run paper/sine-tsmc`.
    """


@app.command()
def run(
    context: typer.Context,
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: Folder = None,
    form: Annotated[
        Format, typer.Option("--format", help="Format of the trajectory that goes into --out.")
    ] = Format.CSV,
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    json: Json = False,
    interpreted: Annotated[
        bool, typer.Option("--interpreted", help="Run in plain Python, thousands of times slower, to debug.")
    ] = False,
    strict: Strict = False,
    verbose: Verbose = False,
) -> None:
    """Simulate one scenario and print its metrics.

    With --out it also writes a report (report.html, its tables as CSV and LaTeX in tables), the trajectory
    in SI units (trajectory.csv, or as --format says), the metrics (metrics.csv, metrics.json) and a plot
    (run.png, run.svg). Other files in the folder are left alone. Where the scenario has commands in mA or %,
    CSV has them too.

    Examples:

    - `hydroservo run paper/sine-pi`
    - `hydroservo run paper/square-tsmc --set load.amplitude=150N --out results --format mat`
    - `hydroservo run my.toml --plugin my_controller.py --set simulation.duration='2 s' --json`
    - `hydroservo run paper/sine-tsmc --out results --figure-size one-column --figure-format pdf`
    """
    from hydroservo.cli.files import list_files, result_files, write_results
    from hydroservo.cli.kernels import log_kernels
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.summary import astray, for_table, run_summary
    from hydroservo.cli.tables import show_run
    from hydroservo.cli.writing import write_or_keep
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json
    from hydroservo.runs.run import Mode, traced
    from hydroservo.runs.trace import dataset

    loop, ending = loaded(scenario, changes, plugins), form.ending
    journal = journal_of(figure_format, figure_size, out, checked_decimal_comma(decimal_comma, out))
    if out:
        report_files = Files(["run"], ["metrics"], journal)
        announce(result_files(out, (f"trajectory{ending}", "metrics.csv"), report_files), [(scenario, loop)])
    with log_kernels(verbose), progress_bar(scenario) as report:
        mode = Mode(compiled=not interpreted, strict=strict)
        with naming(scenario):
            trace = traced(
                loop, None if out else NOTHING, mode, progress=lambda fraction: report(fraction, scenario)
            )
        summary = run_summary(scenario, trace)
        report(1.0, "writing files")

        def write(place: Path) -> list[Path]:
            from hydroservo.cli.reporting import again
            from hydroservo.cli.reports.run import run_files, run_report

            data = dataset(trace)
            said = astray(summary.metrics, loop)
            page = run_report(again(context), for_table(summary, loop), data, said)
            return write_results(place, run_files(summary, data, ending), page, summary._asdict(), journal)

        left = write_or_keep(out, write)
    say_remarks(scenario, trace)
    if json:
        typer.echo(as_json(summary._asdict()))
    else:
        show_run(for_table(summary, loop), trace.fields, astray(summary.metrics, loop))
        list_files(left.files)
    left.check()


@app.command()
def compare(
    context: typer.Context,
    scenarios: Several,
    changes: Changes,
    plugins: Plugins,
    out: Folder = None,
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    json: Json = False,
    strict: Strict = False,
    verbose: Verbose = False,
) -> None:
    """Simulate several scenarios and print their metrics side by side.

    The best of each metric is marked where the scenarios differ in nothing but their controllers; else it
    says in what else they differ. Each --set applies to all of them. With --out it also writes a report
    (report.html, its tables as CSV and LaTeX in tables), the metrics in SI units (metrics.csv, metrics.json)
    and a plot of what is controlled, error and command on common axes (comparison.png, comparison.svg).

    Examples:

    - `hydroservo compare paper/sine-pi paper/sine-backstepping paper/sine-tsmc`
    - `hydroservo compare paper/square-pi paper/square-tsmc --set load.amplitude=150N --out results`
    """
    from hydroservo.cli.files import list_files, result_files, write_results
    from hydroservo.cli.kernels import log_kernels
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.summary import for_table, run_summary
    from hydroservo.cli.tables import show_comparison
    from hydroservo.cli.writing import write_or_keep
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.arguments import check_one_signal
    from hydroservo.runs.conditions import differences, winners
    from hydroservo.runs.results import as_json, metric_fields
    from hydroservo.runs.run import simulate

    loops = [loaded(scenario, changes, plugins) for scenario in scenarios]
    check_one_signal("scenarios", [loop.controls.declared().meaning for loop in loops])
    journal = journal_of(figure_format, figure_size, out, checked_decimal_comma(decimal_comma, out))
    if out:
        report_files = Files(["comparison"], ["metrics"], journal)
        announce(result_files(out, ("metrics.csv",), report_files), [*zip(scenarios, loops, strict=True)])
    datasets = []
    with log_kernels(verbose), progress_bar(scenarios[0]) as report:
        for i, (scenario, loop) in enumerate(zip(scenarios, loops, strict=True)):
            progress = part(report, i, len(loops), scenario)
            record = None if out else NOTHING
            with naming(scenario):
                datasets.append(simulate(loop, record=record, strict=strict, progress=progress))
        summaries = [run_summary(*pair) for pair in zip(scenarios, datasets, strict=True)]
        labels, unequal = short_names(scenarios), differences(datasets)
        said = {
            "runs": [summary._asdict() for summary in summaries],
            "comparable": not unequal,
            "differences": unequal,
        }
        report(1.0, "writing files")
        shown = [for_table(*pair) for pair in zip(summaries, loops, strict=True)]
        best, lines = winners(datasets), unequal_lines(unequal, loops)

        def write(place: Path) -> list[Path]:
            from hydroservo.cli.reporting import again
            from hydroservo.cli.reports.run import comparison_files, comparison_report

            page = comparison_report(again(context), shown, datasets, labels, best, lines)
            return write_results(place, comparison_files(summaries, datasets), page, said, journal)

        left = write_or_keep(out, write)
    for scenario, dataset in zip(scenarios, datasets, strict=True):
        say_remarks(scenario, dataset)
    if json:
        typer.echo(as_json(said))
    else:
        fields = {name: field for one in datasets for name, field in metric_fields(one).items()}
        show_comparison(shown, labels, fields, best, lines)
        list_files(left.files)
    left.check()


app.command()(batch)
app.command()(tune)
app.command()(study)
app.command()(limit)
app.command()(linearize)
app.command()(bode)
app.command()(identify)
app.command("map")(map_logs)
app.command()(log)
app.command()(check)
app.command()(audit)
app.command()(describe)
app.command()(schema)
app.command("app")(page)


@app.command()
def paper(
    out: Annotated[
        Path,
        typer.Option(
            "--out", metavar="DIR", parser=folder_at, help=f"Write the report to this folder. {WHERE}"
        ),
    ] = Path("hydroservo-paper"),
) -> None:
    """Reproduce the terminal sliding mode study of doi:10.1007/s42401-021-00087-w and judge its claims.

    It leaves the figures (PNG, SVG), the metrics (CSV, JSON), the trajectories and a report (report.html)
    that opens in any browser, offline.
    """
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.tables import show_verdicts
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.papers.tsmc_eha_2021.report.folder import report_files, write_report
    from hydroservo.papers.tsmc_eha_2021.study import run_study

    try_outputs(report_files(out))
    with progress_bar("preparing") as report:

        def progress(done: int, total: int, what: str) -> None:
            report(done / total, what)

        study = run_study(progress)
        left = write_or_keep(out, lambda place: [write_report(study, place, progress)])
    show_verdicts(study.verdicts)
    left.check()
    typer.echo(f"report: {left.files[0]}")


@scenarios_app.callback(invoke_without_command=True)
def scenarios(context: typer.Context) -> None:
    """List the built-in scenarios, or show one."""
    from hydroservo.cli.tables import show_titles
    from hydroservo.scenario import scenarios

    if context.invoked_subcommand is None:
        show_titles(scenarios())


@scenarios_app.command("show")
def show_source(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="A built-in name, or a scenario file.", autocompletion=scenarios_like
        ),
    ],
) -> None:
    """Print a scenario, or what others build on, as TOML: the start of one of your own.

    Example:

    - `hydroservo scenarios show paper/sine-tsmc > my.toml`
    - `hydroservo scenarios show rig/1khz`
    """
    from hydroservo.scenario import scenario_source

    print_toml(scenario_source(name))


@studies_app.callback(invoke_without_command=True)
def studies(context: typer.Context) -> None:
    """List the built-in studies, or show one."""
    from hydroservo.cli.tables import show_titles
    from hydroservo.studies.file import studies

    if context.invoked_subcommand is None:
        show_titles(studies())


@studies_app.command("show")
def show_study_source(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="A built-in name, or a study's file.", autocompletion=studies_like
        ),
    ],
) -> None:
    """Print a study as TOML: the start of one of your own.

    Example:

    - `hydroservo studies show small > my-study.toml`
    """
    from hydroservo.studies.file import study_source

    print_toml(study_source(name))


def print_toml(text: str) -> None:
    """TOML in colour on a terminal, and as it is elsewhere."""
    if sys.stdout.isatty():
        from hydroservo.cli.tables import show_toml

        show_toml(text)
    else:
        typer.echo(text, nl=False)


def announce(files: Sequence[Path], loops: Sequence[tuple[str, "Loop"]]) -> None:
    """Before a run: try its files, and say how much memory large trajectories will take.

    Args:
        files: that will be written.
        loops: each with its scenario's name.
    """
    from hydroservo.cli.writing import try_outputs
    from hydroservo.runs.run import trace_size

    size = 0
    for scenario, loop in loops:
        with naming(scenario):
            size += trace_size(loop)
    try_outputs(files, size)
    if size > LARGE_TRACE:
        typer.echo(f"the recorded trajectory will take {size / 2**20:.0f} MiB of memory", err=True)


def part(report: "Report", i: int, count: int, what: str) -> Callable[[float], None]:
    """Reports the progress of one of several runs as that of the whole."""
    return lambda fraction: report((i + fraction) / count, what)


def short_names(scenarios: Sequence[str]) -> list[str]:
    """Names for tables and legends: a file's without folder and ending, if that leaves all distinct."""
    names = [Path(name).stem if name.endswith(".toml") else name for name in scenarios]
    return names if len(set(names)) == len(names) else list(scenarios)
