"""The built-in scenarios and studies: their names, and their texts."""

import sys
from typing import Annotated

import typer

from hydroservo.cli.completion import scenarios_like, studies_like
from hydroservo.cli.failures import ListingGroup
from hydroservo.core.builtin import titles

scenarios_app = typer.Typer(cls=ListingGroup, rich_markup_mode="markdown")
studies_app = typer.Typer(cls=ListingGroup, rich_markup_mode="markdown")


@scenarios_app.callback(invoke_without_command=True)
def list_scenarios(context: typer.Context) -> None:
    """List the built-in scenarios, or show one."""
    from hydroservo.cli.tables import show_titles

    if context.invoked_subcommand is None:
        show_titles(titles("scenario"))


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
def list_studies(context: typer.Context) -> None:
    """List the built-in studies, or show one."""
    from hydroservo.cli.tables import show_titles

    if context.invoked_subcommand is None:
        show_titles(titles("studies"))


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
