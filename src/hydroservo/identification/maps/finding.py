"""What a static map of a machine says."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydroservo._version import __version__
from hydroservo.core.field import Field
from hydroservo.core.formatting import counted
from hydroservo.core.outputs import final_place, write_text
from hydroservo.runs.provenance import origin_of_loop
from hydroservo.runs.results import metrics_csv
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import FileWriter, logs_in

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot
    from hydroservo.identification.maps.result import StaticMap

COLUMNS = (*map(Column, ("number", "value", "from", "to")), UNIT, Column("meaning"))
CAPTION = "The measured curve, and what is fitted to it."
NOTE = "From and to: 95 % interval."


def map_finding(static_map: "StaticMap", logs: Sequence[Path] = ()) -> Finding:
    """What a static map says."""
    kind = static_map.kind.replace("-", " ").capitalize()
    loop = static_map.loop
    return Finding(
        f"{kind} map from {', '.join(static_map.logs)}",
        [map_count_line(static_map)],
        static_map.remarks,
        [Table("numbers", COLUMNS, number_rows(static_map), "What the map gives.", NOTE)],
        [Picture("map", CAPTION, lambda: draw_static_map(static_map))],
        map_numbers(static_map),
        map_files(static_map),
        [] if loop is None else [origin_of_loop(static_map.scenario, loop)],
        logs_in(logs),
    )


def map_count_line(static_map: "StaticMap") -> Line:
    """How many numbers can be determined, and from how much."""
    count, points = len(static_map.numbers), static_map.curve.sizes["point"]
    total = counted(count + len(static_map.undetermined), "number")
    return Line(f"{count} of {total} can be determined, from {counted(points, 'point')} of the curve.")


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


def draw_static_map(static_map: "StaticMap") -> "Plot":
    from hydroservo.figures.identified import plot_static_map

    return plot_static_map(static_map)


def map_numbers(static_map: "StaticMap") -> dict[str, Any]:
    """All numbers of a map, in SI units."""
    return {
        "kind": static_map.kind,
        "scenario": static_map.scenario,
        "version": __version__,
        "logs": list(static_map.logs),
        "numbers": {name: one._asdict() for name, one in static_map.numbers.items()},
        "undetermined": dict(static_map.undetermined),
        "curve": {
            str(name): {
                "values": row.values.tolist(),
                "unit": row.attrs["units"],
                "meaning": row.attrs["long_name"],
            }
            for name, row in static_map.curve.data_vars.items()
        },
        "remarks": list(static_map.remarks),
    }


def map_files(static_map: "StaticMap") -> dict[str, FileWriter]:
    """The points of the curve in SI units, and where a scenario was given one with what was found."""
    curve = static_map.curve
    fields = {
        str(name): Field(row.attrs["units"], row.attrs["long_name"]) for name, row in curve.data_vars.items()
    }
    files: dict[str, FileWriter] = {
        "map.csv": lambda path: write_text(path, metrics_csv(curve.to_dataframe(), fields))
    }
    if static_map.scenario:
        files["scenario.toml"] = lambda path: write_text(path, static_map.toml(final_place(path).parent))
    return files
