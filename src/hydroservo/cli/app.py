"""The commands: the module and the function of each, imported once it is asked for."""

from collections import UserDict
from functools import cache, partial
from pkgutil import resolve_name
from typing import Annotated, Any

import typer
from typer.main import get_group

from hydroservo._version import __version__
from hydroservo.cli.failures import Commands

PLACES = {  # in the order of the help
    "run": "run:run_command",
    "compare": "run:compare_command",
    "batch": "batch:batch_command",
    "tune": "tune:tune_command",
    "study": "study:study_command",
    "limit": "limit:limit_command",
    "linearize": "linearize:linearize_command",
    "bode": "bode:bode_command",
    "identify": "identify:identify_command",
    "map": "map:map_command",
    "log": "log:log_command",
    "check": "check:check_command",
    "audit": "audit:audit_command",
    "describe": "describe:describe_command",
    "schema": "describe:schema_command",
    "app": "page:app_command",
    "paper": "paper:paper_command",
    "scenarios": "listings:scenarios_app",
    "studies": "listings:studies_app",
    "export": "export:export_app",
}


class LateCommands(UserDict[str, Any]):
    """Commands by name, each imported once it is asked for."""

    def __getitem__(self, name: str) -> Any:
        return command_of(name, self.data[name])


@cache
def command_of(name: str, place: str) -> Any:
    """The command that a function is, or a group of some."""
    found, holder = resolve_name(f"hydroservo.cli.{place}"), typer.Typer(rich_markup_mode="markdown")
    add = partial(holder.add_typer, name=name) if isinstance(found, typer.Typer) else holder.command(name)
    add(found)
    return get_group(holder).commands[name]


class AllCommands(Commands):
    """The commands of hydroservo."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands = LateCommands(PLACES)


app = typer.Typer(
    cls=AllCommands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"hydroservo {__version__}")
        raise typer.Exit


@app.callback()
def main_options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Simulate servo-hydraulic axes, and tune, compare and export their controllers.

    Start with `hydroservo scenarios` and `hydroservo run paper/sine-tsmc`.
    """
