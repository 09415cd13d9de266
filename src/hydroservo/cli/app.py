"""The commands: what each takes, and in which order it calls the library."""

import sys
from typing import Annotated

import typer

from hydroservo._version import __version__
from hydroservo.cli.audit import audit
from hydroservo.cli.batch import batch
from hydroservo.cli.bode import bode
from hydroservo.cli.check import check
from hydroservo.cli.completion import scenarios_like, studies_like
from hydroservo.cli.describe import describe, schema
from hydroservo.cli.export import export_app
from hydroservo.cli.failures import Commands, Listing
from hydroservo.cli.identify import identify
from hydroservo.cli.limit import limit
from hydroservo.cli.linearize import linearize
from hydroservo.cli.log import log
from hydroservo.cli.map import map_logs
from hydroservo.cli.page import page
from hydroservo.cli.paper import paper
from hydroservo.cli.run import compare, run
from hydroservo.cli.study import study
from hydroservo.cli.tune import tune

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


app.command()(run)
app.command()(compare)
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
app.command()(paper)


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
