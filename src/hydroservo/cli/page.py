"""The command that opens the page of a scenario."""

from typing import Annotated

import typer

from hydroservo.cli.options import Changes, Plugins, load_loop


def app_command(
    changes: Changes,
    plugins: Plugins,
    scenario: Annotated[
        str,
        typer.Argument(metavar="[SCENARIO]", help="A scenario file (TOML), or the name of a built-in one."),
    ] = "axis/position",
    port: Annotated[
        int | None,
        typer.Option(
            "--port", metavar="PORT", help="Port of the app_command; 0 for any free one. Default: 8642."
        ),
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
        bool, typer.Option("--browser/--no-browser", help="Open the app_command in the browser.")
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
