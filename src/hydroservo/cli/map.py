"""The command that measures a static map of a machine from logs of it."""

from pathlib import Path
from typing import Annotated

import typer

from hydroservo.cli.options import (
    Changes,
    DecimalComma,
    FigureFormat,
    FigureSize,
    Folder,
    Json,
    LogScenario,
    Plugins,
    checked_decimal_comma,
    loaded,
)
from hydroservo.cli.remarks import say_warning


def map_logs(
    context: typer.Context,
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="`valve-flow`, `pressure-gain`, `friction` or `decay`.")
    ],
    logs: Annotated[
        list[Path],
        typer.Argument(
            metavar="LOG...", help="Logs of the machine: CSV, Parquet, MAT, NetCDF, HDF5, MDF or TDMS files."
        ),
    ],
    changes: Changes,
    plugins: Plugins,
    scenario: LogScenario = None,
    out: Folder = None,
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    json: Json = False,
) -> None:
    """Measure a static map of a machine from logs of it, with 95 % intervals.

    KIND is one of: valve-flow, the flow gain, dead band and hysteresis of a valve from slow sweeps of the
    command; pressure-gain, from slow sweeps with blocked ports; friction against velocity from moves at
    constant speed; decay, leakage and bulk modulus from pressures in blocked ports. Headers of logs are those
    that `identify` reads. With --out it writes a report (report.html, its tables as CSV and LaTeX in tables),
    the curve (map.csv), the numbers (metrics.json), a picture (map.png, map.svg) and, with --scenario, a
    scenario with what was found (scenario.toml).

    Examples:

    - `hydroservo map friction bench.csv --scenario my.toml --out friction`
    """
    from hydroservo.cli.files import list_files, result_files, write_results
    from hydroservo.cli.map_tables import as_tables, numbers_table
    from hydroservo.cli.tables import show
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.identification.maps import map_logs as map_of
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json
    from hydroservo.scenario import parse_override

    overrides = dict(map(parse_override, changes))
    journal = journal_of(figure_format, figure_size, out, checked_decimal_comma(decimal_comma, out))
    if out:
        own = ["map.csv", *(["scenario.toml"] if scenario is not None else [])]
        try_outputs(result_files(out, own, Files(["map"], ["numbers"], journal)))
    found = map_of(kind, logs, scenario, changes=overrides, plugins=plugins)
    said = as_tables(found)

    def write(place: Path) -> list[Path]:
        from hydroservo.cli.reporting import again
        from hydroservo.cli.reports.map import map_files, map_report

        loop = None if scenario is None else loaded(scenario, changes, plugins)
        page = map_report(again(context), found, loop, logs)
        return write_results(place, map_files(found, place), page, said, journal)

    left = write_or_keep(out, write)
    for line in found.remarks:
        say_warning(", ".join(found.logs), line)
    if json:
        typer.echo(as_json(said))
    else:
        show(numbers_table(found))
        list_files(left.files)
    left.check()
