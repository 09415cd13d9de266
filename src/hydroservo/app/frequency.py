"""A loop in frequency as a page draws it."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.command_scale import in_command_unit
from hydroservo.linear.bode import bode
from hydroservo.linear.operating_point import operating_point
from hydroservo.linear.parts import parts_of
from hydroservo.linear.places import sliding
from hydroservo.linear.reading import READ, read_as
from hydroservo.linear.responses import responses
from hydroservo.loop import Loop
from hydroservo.runs.cautions import warnings_of

if TYPE_CHECKING:
    import xarray as xr

SKETCHED = 200  # frequencies

CURVES = {
    "open": "opened at the command, L",
    "closed": "closed, demand to signal, T",
    "sensitivity": "sensitivity, S",
    "machine": "machine, command to signal",
    "compliance": "compliance, load to motion",
}
NONE = "\N{EN DASH}"  # for a margin that is no number
MARGINS = ("gain_margin", "phase_margin", "delay_margin", "sensitivity_peak", "oscillation_gain", "bandwidth")


def sketched_bode(loop: Loop, low: float, high: float) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """The curves of :func:`drawn_bode` alone, at fewer frequencies, for while a slider moves.

    Args:
        loop: the loop.
        low: the lowest frequency [Hz].
        high: the highest [Hz].

    Raises:
        ParameterError: the loop has no point that it stays at.
    """
    point = operating_point(sliding(loop), None)  # at rest hysteresis leaves no slope, so that it slides
    grid = np.geomspace(low, high, SKETCHED)
    found = responses(point, parts_of(point)[0], 2.0 * math.pi * grid)
    return {"points": SKETCHED}, rows_of(grid, found.curves)


def rows_of(grid: NDArray[np.float64], curves: Mapping[str, NDArray[np.complex128]]) -> NDArray[np.float32]:
    """Frequencies [Hz], and of each curve its size [dB] and phase [degrees]."""
    rows = [grid]
    for name in CURVES:
        with np.errstate(divide="ignore"):
            size = np.abs(curves[name]) * (in_command_unit("1/V")[1] if name == "machine" else 1.0)
            rows += [20.0 * np.log10(size), np.degrees(np.unwrap(np.angle(curves[name])))]
    return np.vstack(rows).astype(np.float32)


def drawn_bode(loop: Loop) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """The linear responses of a loop: what is said of them, and rows of frequencies, sizes and phases.

    Raises:
        ParameterError: the loop has no point that it stays at, or is not closed there.
    """
    data = bode(loop, measure=False)
    about = {
        "curves": [
            {"name": name, "title": title, "unit": in_command_unit(data[name].attrs["units"])[0]}
            for name, title in CURVES.items()
        ],
        "points": int(data.sizes["frequency"]),
        "stable": bool(data["stable"]),
        "margins": margins_shown(data),
        "warnings": warnings_of(data),
    }
    return about, rows_of(data["frequency"].values, {name: data[name].values for name in CURVES})


def margins_shown(data: "xr.Dataset") -> list[dict[str, str]]:
    """Margins and bandwidth as they are read."""
    return [
        {"name": name, "meaning": READ[name][0], "text": read_as(float(data[name]), READ[name][1], NONE)}
        for name in MARGINS
    ]
