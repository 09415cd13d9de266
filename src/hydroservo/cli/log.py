"""The command that shows how a log is understood."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.options import Changes, Json, LogScenario, Plugins, log_columns_of
from hydroservo.cli.places import WHERE, file_at
from hydroservo.cli.remarks import say_warning

if TYPE_CHECKING:
    from rich.table import Table


def log(
    file: Annotated[
        Path, typer.Argument(metavar="LOG", help="A CSV, Parquet, MAT, NetCDF, HDF5, MDF or TDMS file.")
    ],
    changes: Changes,
    plugins: Plugins,
    scenario: LogScenario = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE",
            parser=file_at,
            help=f"Write a picture of the log: a .png, .svg or .pdf. {WHERE}",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Show how a log is understood: its signals, their units and ranges, its rate and its gaps.

    It reads a log exactly as `identify`, `map` and `bode --log` do. A warning names the columns in which no
    signal is recognised; a scenario can say what they hold, with a scale where units do not convert:

        [identify.columns]
        velocity = "v_piston [mm/s]"
        command = { column = "current [mA]", scale = "0.25 V/mA" }
        period = "10 ms"  # without a column of instants

    Examples:

    - `hydroservo log bench.csv`
    - `hydroservo log bench.csv --scenario my.toml --out bench.png`
    """
    from hydroservo._version import __version__
    from hydroservo.cli.files import PICTURE_ENDINGS
    from hydroservo.cli.tables import show
    from hydroservo.cli.writing import try_outputs
    from hydroservo.errors import ParameterError
    from hydroservo.identification.log import read_log
    from hydroservo.identification.log_summary import log_summary, rate_lines, signal_rows
    from hydroservo.identification.segments import understood
    from hydroservo.identification.signals import COMMAND, TIME
    from hydroservo.runs.results import as_json

    if out:
        if out.suffix.lower() not in PICTURE_ENDINGS:
            raise ParameterError("--out", str(out), f"must end in one of {', '.join(PICTURE_ENDINGS)}")
        try_outputs([out])
    if scenario is None and (changes or plugins):
        option = "--set" if changes else "--plugin"
        raise ParameterError(option, str([*changes, *plugins][0]), "needs --scenario")
    mapping = {} if scenario is None else log_columns_of(scenario, changes, plugins)
    whole = understood(read_log(file, mapping, (TIME,)))
    if out:
        from hydroservo.figures.identified import plot_log
        from hydroservo.figures.style import save_picture

        save_picture(plot_log(whole), out, whole.log.name)
    for line in whole.remarks:
        say_warning(whole.log.name, line)
    if COMMAND not in whole.log.signals:
        say_warning(whole.log.name, "has no command, which identify needs")
    summary = log_summary(whole)
    if json:
        typer.echo(as_json(summary | {"version": __version__}))
    else:
        show(signals_table(whole.log.name, signal_rows(summary)), *rate_lines(summary))
        if out:
            typer.echo(f"written to {out}")


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
