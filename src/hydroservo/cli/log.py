"""The command that shows how a log is understood."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.completion import scenarios_like
from hydroservo.cli.options import Changes, Json, Plugins
from hydroservo.cli.remarks import say_warning

if TYPE_CHECKING:
    from rich.table import Table

__all__ = ["columns_in", "log"]

ENDINGS = (".png", ".svg", ".pdf")


def log(
    file: Annotated[
        Path, typer.Argument(metavar="LOG", help="A CSV, Parquet, MAT, NetCDF, HDF5, MDF or TDMS file.")
    ],
    changes: Changes,
    plugins: Plugins,
    scenario: Annotated[
        str | None,
        typer.Option(
            "--scenario",
            metavar="SCENARIO",
            autocompletion=scenarios_like,
            help="A scenario whose table `[identify.columns]` says which column holds which signal.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", dir_okay=False, help="Draw it: a .png, .svg or .pdf."),
    ] = None,
    json: Json = False,
) -> None:
    """Show how a log is understood: its signals, their units and ranges, its rate and its gaps.

    It reads what `identify`, `map` and `bode --log` read, in the same way. A column that no signal is found
    in is named; a scenario says what it holds, with a scale where units do not convert:

        [identify.columns]
        velocity = "v_piston [mm/s]"
        command = { column = "current [mA]", scale = "0.25 V/mA" }
        period = "10 ms"  # without a column of instants

    Examples:

    - `hydroservo log bench.csv`
    - `hydroservo log bench.csv --scenario my.toml --out bench.png`
    """
    from hydroservo._version import __version__
    from hydroservo.cli.tables import show
    from hydroservo.cli.writing import try_outputs
    from hydroservo.errors import ParameterError
    from hydroservo.identification.log import read_log
    from hydroservo.identification.log_summary import log_summary, rate_lines, signal_rows
    from hydroservo.identification.segments import understood
    from hydroservo.identification.signals import TIME
    from hydroservo.runs.results import as_json

    if out and out.suffix.lower() not in ENDINGS:
        raise ParameterError("--out", str(out), f"must end in one of {', '.join(ENDINGS)}")
    if out:
        try_outputs([out])
    mapping = {} if scenario is None else columns_in(scenario, changes, plugins)
    whole = understood(read_log(file, mapping, (TIME,)))
    if out:
        from hydroservo.figures.identified import plot_log
        from hydroservo.figures.style import save_picture

        save_picture(plot_log(whole), out, whole.log.name)
    for line in whole.remarks:
        say_warning(whole.log.name, line)
    summary = log_summary(whole)
    if json:
        typer.echo(as_json(summary | {"version": __version__}))
    else:
        show(signals_table(whole.log.name, signal_rows(summary)), *rate_lines(summary))
        if out:
            typer.echo(f"written to {out}")


def columns_in(scenario: str, changes: list[str], plugins: list[Path]) -> dict[str, Any]:
    """Which column of a log holds which signal, as a scenario says."""
    from hydroservo.identification.log import log_mapping
    from hydroservo.scenario import assembled, parse_override

    return log_mapping(assembled(scenario, dict(map(parse_override, changes)), plugins).log_columns)


def signals_table(title: str, rows: list[list[str]]) -> "Table":
    """The signals, each with its column and its range."""
    from rich.markup import escape
    from rich.table import Table

    shown = Table(title=escape(title), title_justify="left")
    for name in ("signal", "column", "samples", "lowest", "highest", "unit"):
        shown.add_column(name, justify="right" if name in ("samples", "lowest", "highest") else "left")
    for row in rows:
        shown.add_row(*map(escape, row))
    return shown
