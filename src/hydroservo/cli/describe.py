"""The commands that say what a scenario may hold: to a reader, and to an editor."""

from pathlib import Path
from typing import Annotated

import typer

from hydroservo.cli.completion import types_like
from hydroservo.cli.options import Json, Plugins
from hydroservo.cli.places import WHERE, file_at


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
    from hydroservo.cli.tables import show_descriptions, show_names, show_titles
    from hydroservo.scenario.keys import describe_types, first_sentence, role_named, types_by_role
    from hydroservo.scenario.plugins import load_plugin
    from hydroservo.show.numbers import as_json

    for plugin in plugins:
        load_plugin(plugin)
    if not name:
        types = types_by_role()
        typer.echo(as_json(types)) if json else show_names(types)
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
    from hydroservo.core.outputs import write_text
    from hydroservo.scenario.plugins import load_plugin
    from hydroservo.scenario.schema import scenario_schema
    from hydroservo.show.numbers import as_json

    for plugin in plugins:
        load_plugin(plugin)
    text = as_json(scenario_schema())
    if out is None:
        typer.echo(text)
    else:
        typer.echo(f"written: {write_text(out, text + chr(10))}")
