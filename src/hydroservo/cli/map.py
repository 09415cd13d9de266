"""The command that measures a static map of a machine from logs of it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.completion import scenarios_like
from hydroservo.cli.options import Changes, Folder, Json, Plugins
from hydroservo.cli.remarks import say_warning

if TYPE_CHECKING:
    from hydroservo.identification.maps import StaticMap

__all__ = ["map_logs"]

FOUND = "scenario.toml"
CURVE = "map.csv"


def map_logs(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="`valve-flow`, `pressure-gain`, `friction` or `decay`.")
    ],
    logs: Annotated[
        list[Path],
        typer.Argument(metavar="LOG...", help="Logs of the machine: CSV, Parquet, MAT, NetCDF or MDF files."),
    ],
    changes: Changes,
    plugins: Plugins,
    scenario: Annotated[
        str | None,
        typer.Option(
            "--scenario",
            metavar="SCENARIO",
            autocompletion=scenarios_like,
            help="A scenario file (TOML), or the name of a built-in one, with the machine's known numbers.",
        ),
    ] = None,
    out: Folder = None,
    json: Json = False,
) -> None:
    """Measure a static map of a machine from logs of it, with 95 % intervals.

    KIND is one of: valve-flow, the flow gain, dead band and hysteresis of a valve from slow sweeps of the
    command; pressure-gain, from slow sweeps with blocked ports; friction against velocity from moves at
    constant speed; decay, leakage and bulk modulus from pressures in blocked ports. Headers of logs are those
    that `identify` reads. With --out it writes the curve (map.csv), the numbers (metrics.json), a picture
    (map.png, map.svg) and, with --scenario, a scenario with what was found (scenario.toml).

    Examples:

    - `hydroservo map friction bench.csv --scenario my.toml --out friction`
    """
    from hydroservo.cli.map_tables import as_tables, show_map
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.identification.maps import map_logs as map_of
    from hydroservo.runs.results import as_json
    from hydroservo.scenario import parse_override

    overrides = dict(map(parse_override, changes))
    if out:
        try_outputs(map_files(out, scenario is not None))
    found = map_of(kind, logs, scenario, changes=overrides, plugins=plugins)
    left = write_or_keep(out, lambda place: write_map(place, found))
    for line in found.remarks:
        say_warning(", ".join(found.logs), line)
    if json:
        typer.echo(as_json(as_tables(found)))
    else:
        show_map(found)
        if left.files:
            typer.echo(f"written to {left.files[0].parent}: {', '.join(file.name for file in left.files)}")
    left.check()


def map_files(folder: Path, on_scenario: bool) -> list[Path]:
    """What :func:`write_map` writes.

    Args:
        folder: where to.
        on_scenario: whether a scenario was given.
    """
    from hydroservo.runs.results import METRICS

    written = [FOUND] if on_scenario else []
    return [folder / name for name in (*written, CURVE, "map.png", "map.svg", METRICS)]


def write_map(folder: Path, found: "StaticMap") -> list[Path]:
    """The scenario, the curve, the picture and the numbers of a map; returns what was written."""
    from hydroservo.cli.map_tables import as_tables
    from hydroservo.field import Field
    from hydroservo.figures.static_map import plot_static_map
    from hydroservo.figures.style import save_figure
    from hydroservo.outputs import staged, write_text
    from hydroservo.runs.results import METRICS, metrics_csv, write_metrics

    every = found.curve.data_vars.items()
    fields = {str(name): Field(row.attrs["units"], row.attrs["long_name"]) for name, row in every}
    with staged(folder, last=METRICS) as stage:
        if found.scenario:
            write_text(stage / FOUND, found.toml(folder))
        write_text(stage / CURVE, metrics_csv(found.curve.to_dataframe(), fields))
        save_figure(plot_static_map(found), stage / "map", f"map {found.kind}")
        content: dict[str, Any] = as_tables(found)
        write_metrics(stage, content)
    return map_files(folder, bool(found.scenario))
