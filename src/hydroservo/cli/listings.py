"""The built-in scenarios and studies: their names, and their texts."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table

from hydroservo.cli.commands import ListingGroup
from hydroservo.cli.frame import PICTURE_ENDINGS, CommandOutput, with_output
from hydroservo.cli.options import (
    WHERE,
    Json,
    Plugins,
    file_at,
    parts_like,
    scenarios_like,
    studies_like,
    types_like,
)
from hydroservo.core.builtin import titles
from hydroservo.core.field import CONTROLLED
from hydroservo.core.outputs import write_text
from hydroservo.show.terminal import show

if TYPE_CHECKING:
    from hydroservo.scenario.descriptions import Description

scenarios_app = typer.Typer(cls=ListingGroup, rich_markup_mode="markdown")
studies_app = typer.Typer(cls=ListingGroup, rich_markup_mode="markdown")
parts_app = typer.Typer(cls=ListingGroup, rich_markup_mode="markdown")


@scenarios_app.callback(invoke_without_command=True)
def list_scenarios(context: typer.Context) -> None:
    """List the built-in scenarios, or show one."""
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


@parts_app.callback(invoke_without_command=True)
def list_parts(
    context: typer.Context,
    folder: Annotated[
        Path | None,
        typer.Option("--folder", metavar="DIR", help="List the parts in this folder of your own, too."),
    ] = None,
    json: Json = False,
) -> None:
    """List the parts that a scenario may take by name, or show one.

    A table takes a part with `part = "valve/..."`, and keys beside it change single numbers. With --json each
    comes with its source.

    Examples:

    - `hydroservo parts`
    - `hydroservo parts --json`
    """
    from hydroservo.scenario.part_sheets import part_sources
    from hydroservo.show.files import as_json

    if context.invoked_subcommand is None:
        found = part_sources(folder)
        if json:
            typer.echo(
                as_json({name: {"title": one.title, "source": one.source} for name, one in found.items()})
            )
        else:
            show_titles({name: one.title for name, one in found.items()})


@parts_app.command("show")
@with_output("Draw it: a .png, .svg or .pdf. Into a folder goes a report too.", PICTURE_ENDINGS)
def show_part(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="A built-in part, or the file of one.", autocompletion=parts_like
        ),
    ],
    plugins: Plugins,
    output: CommandOutput,
) -> None:
    """Show a part as a data sheet: its numbers, the source of each, and what its block makes of them.

    What the part leaves to the machine, such as the load of a cylinder, is assumed for the sheet, and named.
    With --out it draws the curves that data sheets have: flow over command and frequency response of a valve,
    natural frequency of a cylinder over its stroke, bulk modulus of an oil, oil in an accumulator and flow of
    a pump over pressure.

    Examples:

    - `hydroservo parts show edges/4wrpeh-6-40`
    - `hydroservo parts show cylinder/iso-6020-2-63-45 --out cylinder.png`
    """
    from hydroservo.scenario.finding import part_finding
    from hydroservo.scenario.part_sheets import part
    from hydroservo.scenario.registry import load_plugin

    for plugin in plugins:
        load_plugin(plugin)
    output.present(name, lambda _: part(name), part_finding)


@studies_app.callback(invoke_without_command=True)
def list_studies(context: typer.Context) -> None:
    """List the built-in studies, or show one."""
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
    from hydroservo.studies.spec_file import study_source

    print_toml(study_source(name))


def print_toml(text: str) -> None:
    """TOML in colour on a terminal, and as it is elsewhere."""
    if sys.stdout.isatty():
        highlighted = Syntax("", "toml", background_color="default").highlight(text)
        Console().print(highlighted, soft_wrap=True, end="")
    else:
        typer.echo(text, nl=False)


def describe_command(
    plugins: Plugins,
    name: Annotated[
        str,
        typer.Argument(
            metavar="[NAME]",
            help="A type such as PID, a role, or a table of a scenario.",
            autocompletion=types_like,
        ),
    ] = "",
    json: Json = False,
) -> None:
    """Say which types a scenario may name, and which keys each takes, with units, ranges and defaults.

    Without a name it lists all types by their roles.

    Examples:

    - `hydroservo describe`
    - `hydroservo describe controller`
    - `hydroservo describe Cylinder.from_diameters`
    """
    from hydroservo.scenario.descriptions import describe_types, first_sentence, role_named, types_by_role
    from hydroservo.scenario.registry import load_plugin
    from hydroservo.show.files import as_json

    for plugin in plugins:
        load_plugin(plugin)
    if not name:
        types = types_by_role()
        typer.echo(as_json(types)) if json else show_titles(
            {role: ", ".join(names) for role, names in types.items()}
        )
    elif of_role := role_named(name):
        titles = {one: first_sentence(maker) for one, maker in of_role.items()}
        typer.echo(as_json(titles)) if json else show_titles(titles)
    else:
        found = describe_types(name)
        typer.echo(as_json([one.as_dict() for one in found])) if json else show_descriptions(found)


def schema_command(
    plugins: Plugins,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", parser=file_at, help=f"Write it to this file. {WHERE}"),
    ] = None,
) -> None:
    """Print the JSON Schema of scenarios, with which an editor completes and checks them as they are typed.

    The line `#:schema ./hydroservo.schema.json` at the top of a scenario tells an editor that knows TOML's
    schemas, such as Even Better TOML in VS Code, where it is.

    Examples:

    - `hydroservo schema --out hydroservo.schema.json`
    """
    from hydroservo.scenario.descriptions import scenario_schema
    from hydroservo.scenario.registry import load_plugin
    from hydroservo.show.files import as_json

    for plugin in plugins:
        load_plugin(plugin)
    text = as_json(scenario_schema())
    if out is None:
        typer.echo(text)
    else:
        typer.echo(f"written: {write_text(out, text + chr(10))}")


def show_titles(titles: Mapping[str, str]) -> None:
    """Names and titles of scenarios or studies."""
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, text in titles.items():
        table.add_row(f"[bold]{escape(name)}[/]", escape(text))
    show(table)


def show_descriptions(found: "Sequence[Description]") -> None:
    """Types of one name in words, each with the keys of its table."""
    for about in found:
        table = Table(caption_justify="left")
        for name in ("key", "default", "unit", "range"):
            table.add_column(name, no_wrap=True)
        table.add_column("meaning")
        for key in about.keys:
            one = key.as_dict()
            default = one["default"] or "[yellow]needed[/]"
            table.add_row(one["name"], default, *(escape(one[name]) for name in ("unit", "range", "meaning")))
        units = [key.as_dict()["unit"] for key in about.keys]
        said = ['a plain number is in this unit; others in quotes, such as "63 mm"'] if any(units) else []
        if any(CONTROLLED in unit for unit in units):
            said.append(f"{CONTROLLED}: the unit of the controlled signal, such as m/s or m")
        table.caption = "\n".join(said)
        heading = f"[bold]{escape(about.name)}[/]: {', '.join(about.roles)}"
        show(heading, "", escape(about.text), "", table if about.keys else "It takes no keys.")
