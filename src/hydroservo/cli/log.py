"""The command that shows how a log is understood."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from hydroservo.cli.frame import PICTURE_ENDINGS, CommandOutput, with_output
from hydroservo.cli.options import Changes, LogScenario, Plugins, log_columns_of


@with_output("Draw it: a .png, .svg or .pdf. Into a folder goes a report too.", endings=PICTURE_ENDINGS)
def log_command(
    file: Annotated[
        Path, typer.Argument(metavar="LOG", help="A CSV, Parquet, MAT, NetCDF, HDF5, MDF or TDMS file.")
    ],
    changes: Changes,
    plugins: Plugins,
    answer: CommandOutput,
    scenario: LogScenario = None,
) -> None:
    """Show how a log is understood: its signals, their units and ranges, its rate and its gaps.

    It reads a log exactly as `identify`, `map` and `bode --log` do. A warning names the columns in which no
    signal is recognised; a scenario can say what they hold, with a scale where units do not convert:

        [identify.columns]
        velocity = "v_piston [mm/s]"
        command = { column = "current [mA]", scale = "0.25 V/mA" }
        period = "10 ms"  # without a column of instants

    A folder as --out gets a report (report.html, its table as CSV and LaTeX in tables), a picture of the log
    (log.png, log.svg) and the numbers (metrics.json).

    Examples:

    - `hydroservo log bench.csv`
    - `hydroservo log bench.csv --scenario my.toml --out bench.png`
    """
    from hydroservo.core.errors import ParameterError
    from hydroservo.identification.finding import log_finding
    from hydroservo.identification.log import TIME, read_log
    from hydroservo.identification.segments import understood

    if scenario is None and (changes or plugins):
        option = "--set" if changes else "--plugin"
        raise ParameterError(option, str([*changes, *plugins][0]), "needs --scenario")
    mapping = {} if scenario is None else log_columns_of(scenario, changes, plugins)
    answer(
        str(file), lambda _: understood(read_log(file, mapping, (TIME,))), partial(log_finding, logs=[file])
    )
