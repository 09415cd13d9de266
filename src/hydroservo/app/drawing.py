"""A run as a page draws it: panels of lines, the machine's live values, and metrics."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.field import Field
from hydroservo.core.formatting import common_unit, number, with_label
from hydroservo.figures.circuit import circuit
from hydroservo.linear.bode import bode
from hydroservo.linear.finding import bode_finding
from hydroservo.linear.moving_margins import without_hysteresis
from hydroservo.linear.operating_point import operating_point
from hydroservo.linear.system import part_slopes
from hydroservo.linear.view import responses
from hydroservo.runs.results import metric_fields
from hydroservo.runs.run_finding import run_finding
from hydroservo.show import Table
from hydroservo.show.table import texts_of

if TYPE_CHECKING:
    import xarray as xr

Vector = NDArray[np.float64]

MOST_POINTS = 6000  # of a line: more than any screen has columns
DEMAND, CONTROLLED, COMMAND = "reference.value", "controlled.value", "controller.u"
PRESSURES = ("plant.pressure_a", "plant.pressure_b", "plant.load_pressure")
LIVE = (  # and all of the drive: what the circuit shows
    *("plant.position", "plant.velocity", "plant.hydraulic_force", "plant.carried.angle"),
    *("valve.opening", "supply.pressure", "load.force"),
)
NAMES = {
    DEMAND: "demand",
    CONTROLLED: "controlled",
    COMMAND: "command",
    "plant.pressure_a": "chamber A",
    "plant.pressure_b": "chamber B",
    "plant.load_pressure": "load pressure",
}

FEWEST = 30  # samples, of which one may be an outlier
SPIKES = 1e-3  # of the samples at either end that may be outliers, and three of few
LAST = 0.05  # of the samples of a run that is lost, the last of which are far from all others
FAR = 3.0  # times the span of all others, beyond which a sample is one
FLAT = 0.05  # of its size, which a line that hardly changes counts as spanning
SKETCHED = 200  # frequencies

CURVES = {
    "open": "opened at the command, L",
    "closed": "closed, demand to signal, T",
    "sensitivity": "sensitivity, S",
    "machine": "machine, command to signal",
    "compliance": "compliance, load to motion",
}


class RunDrawing(NamedTuple):
    """What a page needs of a run."""

    about: dict[str, Any]  # everything but the numbers of lines
    rows: NDArray[np.float32]  # those, shape (lines, points), in the order of ``about["lines"]``


def draw_page_run(loop: Loop, run: "xr.Dataset", more: Sequence[str]) -> RunDrawing:
    signals = [str(name) for name, one in run.data_vars.items() if one.dims]
    meaning = loop.controls.declared().meaning
    panels = [
        page_panel(meaning, run, [DEMAND, CONTROLLED]),
        error_panel(run),
        page_panel("command", run, [COMMAND]),
        page_panel("pressures", run, [path for path in PRESSURES if path in signals]),
        *(page_panel(path, run, [path]) for path in more if path in signals),
    ]
    finding = run_finding(run)
    panels = [one for one in panels if one["lines"]]
    shown = [path for path in signals if path in LIVE or path.startswith("drive.")]
    live = [page_panel(path, run, [path]) for path in shown]
    lines = [line for one in (*panels, *live) for line in one["lines"]]
    time = run["time"].values
    rows = thin_lines(time, [line.pop("values") for line in lines])
    about = {
        "panels": panels,
        "live": live,
        "points": int(rows.shape[1]),
        "signals": signals,
        "metrics": metric_entries(run, finding.tables[0]),
        "circuit": circuit(loop),
        "warnings": [*map(str, finding.doubts), *finding.remarks],
        "diverged": str(finding.lead[0]) if bool(run["diverged"]) else "",
        "duration": loop.simulation.duration,
        "substeps": run.attrs.get("substeps", loop.simulation.substeps),
        "hash": run.attrs["hash"],
    }
    return RunDrawing(about, rows)


def page_panel(title: str, run: "xr.Dataset", paths: Sequence[str]) -> dict[str, Any]:
    """Some signals of one unit on common axes."""
    lines = [
        {"path": path, "name": NAMES.get(path, run[path].attrs["long_name"]), "values": run[path].values}
        for path in paths
    ]
    unit = run[paths[0]].attrs["units"] if paths else ""
    return panel_on_axes(title, unit, lines, bool(run["diverged"]))


def error_panel(run: "xr.Dataset") -> dict[str, Any]:
    """Demand less what is controlled."""
    line = {"path": "error", "name": "", "values": run[DEMAND].values - run[CONTROLLED].values}
    return panel_on_axes("error", run[CONTROLLED].attrs["units"], [line], bool(run["diverged"]))


def panel_on_axes(
    title: str, si: str, lines: Sequence[dict[str, Any]], diverged: bool = False
) -> dict[str, Any]:
    """Lines on common axes, their SI values in a readable unit, which go over what the lines do."""
    ends = extent_of([line["values"] for line in lines], diverged)
    unit, factor = common_unit(ends or (), si)
    return {
        "title": title,
        "unit": unit,
        "factor": factor,
        "lines": [{**line, "values": factor * line["values"]} for line in lines],
        "extent": ends and [factor * ends.low, factor * ends.high],
        "clipped": outliers_text(ends, unit, factor) if ends else "",
    }


def thin_lines(time: Vector, lines: Sequence[Vector]) -> NDArray[np.float32]:
    """Instants and lines of few enough points, which keep the least and the largest of each stretch."""
    rows = np.vstack([time, *lines])
    count = rows.shape[1]
    if count <= MOST_POINTS:
        return rows.astype(np.float32)
    size = math.ceil(2 * count / MOST_POINTS)
    kept = count - count % size
    parts = rows[:, :kept].reshape(len(rows), -1, size)
    first = parts[0, :, 0]
    out = np.empty((len(rows), 2 * parts.shape[1]))
    with np.errstate(invalid="ignore"):
        least, most = parts.min(axis=2), parts.max(axis=2)
    rising = parts[:, :, 0] <= parts[:, :, -1]
    out[:, 0::2] = np.where(rising, least, most)
    out[:, 1::2] = np.where(rising, most, least)
    out[0, 0::2], out[0, 1::2] = first, parts[0, :, size // 2]
    return out.astype(np.float32)


def metric_entries(run: "xr.Dataset", table: Table) -> list[dict[str, Any]]:
    """The metrics of a run, as they are read; what is compared has a value."""
    fields = metric_fields(run)
    return [
        {
            "name": name,
            "meaning": meaning,
            "text": with_label(text, unit),
            "value": comparable_value(fields[name], run[name]),
        }
        for name, text, unit, meaning in texts_of(table).rows
    ]


def comparable_value(field: Field, value: "xr.DataArray") -> float | None:
    """A metric of which less is better; None of others, and where there is no number."""
    return float(value) if field.smaller_is_better and math.isfinite(value) else None


class Extent(NamedTuple):
    """How far an axis goes."""

    low: float  # the least value on it
    high: float  # the largest
    outliers: int  # how many samples lie beyond
    least: float  # of all samples
    most: float  # of all samples


def extent_of(lines: Sequence[Vector], diverged: bool = False) -> Extent | None:
    """The extent of lines on common axes; None where they have no number."""
    rows = [one[np.isfinite(one)] for one in lines]
    rows = [one for one in rows if one.size]
    if not rows:
        return None
    cores = [range_without_outliers(one, LAST if diverged else SPIKES) for one in rows]
    low, high = min(one[0] for one in cores), max(one[1] for one in cores)
    room = FAR * max(high - low, FLAT * max(abs(low), abs(high)))
    every = np.concatenate(rows)
    inside = every[(every >= low - room) & (every <= high + room)] if room > 0.0 else every
    beside = every.size - inside.size
    return Extent(float(inside.min()), float(inside.max()), beside, float(every.min()), float(every.max()))


def outliers_text(extent: Extent, unit: str, factor: float) -> str:
    """What lies beyond an axis, such as "3 samples up to 41 bar"; "" if nothing does."""
    if not extent.outliers:
        return ""
    ends = [f"up to {number(factor * extent.most)} {unit}".strip()] if extent.most > extent.high else []
    ends += [f"down to {number(factor * extent.least)} {unit}".strip()] if extent.least < extent.low else []
    return f"{extent.outliers} sample{'s' if extent.outliers > 1 else ''} {' and '.join(ends)}"


def range_without_outliers(values: Vector, share: float) -> tuple[float, float]:
    """The least and the largest value, but for a share at either end."""
    if values.size < FEWEST:
        return float(values.min()), float(values.max())
    beside = max(3, int(share * values.size))
    places = beside, values.size - 1 - beside
    low, high = np.partition(values, places)[list(places)]
    return float(low), float(high)


def sketch_bode(loop: Loop, low: float, high: float) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """The curves of :func:`draw_bode` alone, at fewer frequencies [Hz], for while a slider moves."""
    sliding = without_hysteresis(loop)  # which at rest leaves no slope
    point = operating_point(sliding, None)
    grid = np.geomspace(low, high, SKETCHED)
    found = responses(point, part_slopes(point)[0], 2.0 * math.pi * grid)
    return {"points": SKETCHED}, curve_rows(grid, found.curves)


def curve_rows(
    grid: NDArray[np.float64], curves: Mapping[str, NDArray[np.complex128]]
) -> NDArray[np.float32]:
    """Frequencies [Hz], and of each curve its size [dB] and phase [degrees]."""
    rows = [grid]
    for name in CURVES:
        with np.errstate(divide="ignore"):
            size = np.abs(curves[name]) * (in_command_unit("1/V")[1] if name == "machine" else 1.0)
            rows += [20.0 * np.log10(size), np.degrees(np.unwrap(np.angle(curves[name])))]
    return np.vstack(rows).astype(np.float32)


def draw_bode(loop: Loop) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """The linear responses of a loop: what is said of them, and rows of frequencies, sizes and phases."""
    data = bode(loop, measure=False)
    finding = bode_finding(data)
    about = {
        "curves": [
            {"name": name, "title": title, "unit": in_command_unit(data[name].attrs["units"])[0]}
            for name, title in CURVES.items()
        ],
        "points": int(data.sizes["frequency"]),
        "margins": margin_entries(finding.tables[0]),
        "warnings": [*map(str, finding.doubts), *finding.remarks],
    }
    return about, curve_rows(data["frequency"].values, {name: data[name].values for name in CURVES})


def margin_entries(table: Table) -> list[dict[str, str]]:
    """Margins and bandwidths as they are read."""
    rows = texts_of(table).rows
    return [{"meaning": name, "text": with_label(text, unit)} for name, text, unit in rows]
