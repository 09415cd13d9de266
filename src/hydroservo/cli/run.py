"""The commands that run scenarios: one, or several side by side."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.commands import errors_name_scenario
from hydroservo.cli.frame import CommandOutput, with_output
from hydroservo.cli.messages import Report, log_kernels
from hydroservo.cli.options import Changes, Plugins, Scenario, Scenarios, Strict, Verbose, load_loop
from hydroservo.core.errors import require
from hydroservo.runs.arguments import check_one_signal
from hydroservo.runs.results import ResultFormat

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.control.loop import Loop
    from hydroservo.runs.trace import Trace

NOTHING: tuple[str, ...] = ()  # no trajectory is kept where nothing will be written
LARGE_TRACE = 2**28  # bytes; a larger trajectory is announced before the run


@with_output()
def run_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    output: CommandOutput,
    form: Annotated[
        ResultFormat, typer.Option("--format", help="Format of the trajectory that goes into --out.")
    ] = ResultFormat.CSV,
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
    from hydroservo.runs.kernels import Mode
    from hydroservo.runs.run import run_trace
    from hydroservo.runs.run_finding import run_finding

    if output.folder and form is ResultFormat.PARQUET:
        require("pyarrow", "parquet", "Parquet")
    loop = load_loop(scenario, changes, plugins)
    size = trace_memory([(scenario, loop)]) if output.folder else 0
    mode = Mode(compiled=not interpreted, strict=strict)

    def ask(report: Report) -> "Trace":
        with log_kernels(verbose), errors_name_scenario(scenario):
            record = None if output.folder else NOTHING
            return run_trace(loop, record, mode, progress=lambda fraction: report(fraction, scenario))

    output.present(scenario, ask, partial(run_finding, scenario=scenario, ending=form.ending), size=size)


@with_output()
def compare_command(
    scenarios: Scenarios,
    changes: Changes,
    plugins: Plugins,
    output: CommandOutput,
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
    from hydroservo.runs.comparison import comparison_finding
    from hydroservo.runs.run import simulate

    loops = [load_loop(scenario, changes, plugins) for scenario in scenarios]
    check_one_signal("scenarios", [loop.controls.declared().meaning for loop in loops])
    size = trace_memory([*zip(scenarios, loops, strict=True)]) if output.folder else 0

    def ask(report: Report) -> "list[xr.Dataset]":
        runs = []
        with log_kernels(verbose):
            for i, (scenario, loop) in enumerate(zip(scenarios, loops, strict=True)):
                progress = progress_of_part(report, i, len(loops), scenario)
                record = None if output.folder else NOTHING
                with errors_name_scenario(scenario):
                    runs.append(simulate(loop, record=record, strict=strict, progress=progress))
        return runs

    say = partial(comparison_finding, scenarios=scenarios, labels=short_names(scenarios), loops=loops)
    output.present("", ask, say, size=size)


def trace_memory(loops: "Sequence[tuple[str, Loop]]") -> int:
    """How much memory the trajectories of scenarios will take [bytes]; a large one is said on stderr."""
    from hydroservo.runs.trace import trace_size

    size = 0
    for scenario, loop in loops:
        with errors_name_scenario(scenario):
            size += trace_size(loop)
    if size > LARGE_TRACE:
        several = "trajectory" if len(loops) == 1 else "trajectories"
        typer.echo(f"the recorded {several} will take {size / 2**20:.0f} MiB of memory", err=True)
    return size


def progress_of_part(report: Report, i: int, count: int, what: str) -> Callable[[float], None]:
    """Reports the progress of one of several runs as that of the whole."""
    return lambda fraction: report((i + fraction) / count, what)


def short_names(scenarios: Sequence[str]) -> list[str]:
    """Names for tables and legends: a file's without folder and ending, if that leaves all distinct."""
    names = [Path(name).stem if name.endswith(".toml") else name for name in scenarios]
    return names if len(set(names)) == len(names) else list(scenarios)


def app_command(
    changes: Changes,
    plugins: Plugins,
    scenario: Annotated[
        str,
        typer.Argument(metavar="[SCENARIO]", help="A scenario file (TOML), or the name of a built-in one."),
    ] = "axis/position",
    port: Annotated[
        int | None,
        typer.Option("--port", metavar="PORT", help="Port of the page; 0 for any free one. Default: 8642."),
    ] = None,
    host: Annotated[
        str,
        typer.Option(
            "--host",
            metavar="ADDRESS",
            help="Address of this machine to listen at. Beyond this machine the page asks for a token, "
            "which the address printed holds; it is not encrypted.",
        ),
    ] = "127.0.0.1",
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
) -> None:
    """Open a local web page for a scenario: change a number, and see what follows.

    The page shows the machine as a hydraulic circuit, a run, the Bode plot and the metrics, has a field for
    each number and a list for each type, compares pinned runs, takes logs, and saves the scenario as TOML.
    It is served by this computer to itself until Ctrl-C, and needs no network, but the libraries of
    `pip install 'hydroservo[app]'`.

    Examples:

    - `hydroservo app axis/position`
    - `hydroservo app my.toml --plugin my_controller.py --no-browser --port 0`
    """
    from hydroservo.app import Address, serve

    load_loop(scenario, changes, plugins)  # what is wrong with it is said here and now
    serve(scenario, changes, plugins, Address(host, port), browser, print_address)


def print_address(address: str) -> None:
    typer.echo(f"{address}\nCtrl-C ends it")
