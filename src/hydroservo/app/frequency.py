"""A loop in frequency as a page draws it."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.formatting import with_label
from hydroservo.linear.bode import bode
from hydroservo.linear.bode_finding import bode_finding
from hydroservo.linear.operating_point import operating_point
from hydroservo.linear.parts import parts_of
from hydroservo.linear.places import sliding
from hydroservo.linear.responses import responses
from hydroservo.show import Table
from hydroservo.show.table import texts_of

SKETCHED = 200  # frequencies

CURVES = {
    "open": "opened at the command, L",
    "closed": "closed, demand to signal, T",
    "sensitivity": "sensitivity, S",
    "machine": "machine, command to signal",
    "compliance": "compliance, load to motion",
}


def sketch_bode(loop: Loop, low: float, high: float) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """The curves of :func:`draw_bode` alone, at fewer frequencies, for while a slider moves.

    Args:
        loop: the loop.
        low: the lowest frequency [Hz].
        high: the highest [Hz].
    """
    point = operating_point(sliding(loop), None)  # at rest hysteresis leaves no slope, so that it slides
    grid = np.geomspace(low, high, SKETCHED)
    found = responses(point, parts_of(point)[0], 2.0 * math.pi * grid)
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
