"""The command that measures a static map of a machine from logs of it."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from hydroservo.cli.frame import CommandOutput, with_output
from hydroservo.cli.options import Changes, LogScenario, Plugins


@with_output()
def map_command(
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
    answer: CommandOutput,
    scenario: LogScenario = None,
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
    from hydroservo.identification.maps import map_logs
    from hydroservo.identification.maps.finding import map_finding
    from hydroservo.scenario import parse_override

    overrides = dict(map(parse_override, changes))
    answer(
        ", ".join(map(str, logs)),
        lambda _: map_logs(kind, logs, scenario, changes=overrides, plugins=plugins),
        partial(map_finding, logs=logs),
    )
