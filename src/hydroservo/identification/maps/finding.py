"""What a static map of a machine says."""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydroservo._version import __version__
from hydroservo.core.field import Field
from hydroservo.core.formatting import counted, quantity
from hydroservo.core.outputs import final_place, write_text
from hydroservo.runs.provenance import origin_of_loop
from hydroservo.runs.results import metrics_csv
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import FileWriter, logs_in

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot
    from hydroservo.identification.maps.result import StaticMap

COLUMNS = (*map(Column, ("number", "value", "from", "to")), UNIT, Column("meaning"))
CAPTION = "The measured curve, and what is fitted to it."
SHOWN = 9  # points of a characteristic, along its command
NOTE = "From and to: 95 % interval."


def map_finding(static_map: "StaticMap", logs: Sequence[Path] = ()) -> Finding:
    """What a static map says."""
    kind = static_map.kind.replace("-", " ").capitalize()
    loop = static_map.loop
    return Finding(
        f"{kind} map from {', '.join(static_map.logs)}",
        [*map_count_lines(static_map)],
        static_map.remarks,
        [
            Table("numbers", COLUMNS, number_rows(static_map), "What the map gives.", NOTE),
            *([] if static_map.characteristic is None else [point_table(static_map.characteristic)]),
        ],
        [Picture("map", CAPTION, lambda: draw_static_map(static_map))],
        map_numbers(static_map),
        map_files(static_map),
        [] if loop is None else [origin_of_loop(static_map.scenario, loop)],
        logs_in(logs),
    )


def map_count_lines(static_map: "StaticMap") -> Iterator[Line]:
    """How many numbers can be determined, and from how much."""
    count, points = len(static_map.numbers), static_map.curve.sizes["point"]
    total = counted(count + len(static_map.undetermined), "number")
    yield Line(f"{count} of {total} can be determined, from {counted(points, 'point')} of the curve.")
    if static_map.characteristic is not None:
        command = static_map.characteristic["command"].values
        low, high = (quantity(float(command[i]), "V") for i in (0, -1))
        yield Line(f"The table has {counted(command.size, 'point')} from {low} to {high}.")


def number_rows(static_map: "StaticMap") -> list[list[Cell]]:
    """The numbers with their intervals, and why others cannot be determined."""
    rows = [
        [
            Cell(name),
            *(Cell(end, one.unit) for end in (one.value, one.low, one.high)),
            Cell(),
            Cell(one.meaning),
        ]
        for name, one in static_map.numbers.items()
    ]
    unknown = [
        [Cell(name), *[Cell(math.nan)] * 3, Cell(), Cell(f"cannot be determined: {why}", mark=Mark.DOUBTFUL)]
        for name, why in static_map.undetermined.items()
    ]
    return rows + unknown


def point_table(table: "xr.Dataset") -> Table:
    """Some points of a characteristic, evenly along its command, and those where it leaves 0."""
    name = table.attrs["quantity"]
    names = ("command", name, f"{name}_half", "hysteresis", "samples")
    command, answer, half, hysteresis, samples = (table[column] for column in names)
    evenly = np.abs(
        command.values[:, np.newaxis] - np.linspace(command.values[0], command.values[-1], SHOWN)
    ).argmin(axis=0)
    shown = np.union1d(evenly, np.flatnonzero(answer.values == 0.0))
    units = [one.attrs["units"] for one in (command, answer, half, hysteresis, samples)]
    columns = [
        Column("command", units[0]),
        Column(str(answer.name), units[1]),
        Column("95 % interval, half", units[2]),
        Column("hysteresis", units[3]),
        Column("samples"),
    ]
    rows = [
        [
            *(Cell(float(one.values[i])) for one in (command, answer, half, hysteresis)),
            Cell(int(samples.values[i])),
        ]
        for i in shown
    ]
    note = f"{shown.size} of {counted(command.size, 'point')}; all are in characteristic.csv."
    return Table("characteristic", columns, rows, f"The table: {answer.attrs['long_name']}.", note)


def draw_static_map(static_map: "StaticMap") -> "Plot":
    from hydroservo.figures.identified import plot_static_map

    return plot_static_map(static_map)


def column_numbers(rows: "xr.Dataset") -> dict[str, Any]:
    """The columns of a curve with their units."""
    return {
        str(name): {
            "values": row.values.tolist(),
            "unit": row.attrs["units"],
            "meaning": row.attrs["long_name"],
        }
        for name, row in rows.data_vars.items()
    }


def map_numbers(static_map: "StaticMap") -> dict[str, Any]:
    """All numbers of a map, in SI units."""
    table = static_map.characteristic
    return {
        "kind": static_map.kind,
        "scenario": static_map.scenario,
        "version": __version__,
        "logs": list(static_map.logs),
        "numbers": {name: one._asdict() for name, one in static_map.numbers.items()},
        "undetermined": dict(static_map.undetermined),
        "curve": column_numbers(static_map.curve),
        **({} if table is None else {"characteristic": column_numbers(table)}),
        "remarks": list(static_map.remarks),
    }


def map_files(static_map: "StaticMap") -> dict[str, FileWriter]:
    """The points of the curve, and the table of a characteristic; a scenario with what was found."""
    tables = {"map.csv": static_map.curve, "characteristic.csv": static_map.characteristic}
    files: dict[str, FileWriter] = {
        name: partial(write_columns, rows) for name, rows in tables.items() if rows is not None
    }
    if static_map.scenario:
        files["scenario.toml"] = lambda path: write_text(path, static_map.toml(final_place(path).parent))
    return files


def write_columns(rows: "xr.Dataset", path: Path) -> None:
    """Columns as CSV, in SI units and that of commands."""
    fields = {
        str(name): Field(row.attrs["units"], row.attrs["long_name"]) for name, row in rows.data_vars.items()
    }
    write_text(path, metrics_csv(rows.to_dataframe(), fields))
