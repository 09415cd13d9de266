"""The picture of a static map: points with their scatter, and the lines through them."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from hydroservo.figures.panels import axis_unit, largest
from hydroservo.figures.style import GREY, PALETTE, Plot, figure, style

if TYPE_CHECKING:
    from hydroservo.identification.maps import StaticMap

HEIGHT = 3.2  # inch
MARGIN = 0.03  # of the axes
DOT = 3.2  # points
DIRECTIONS = ("command falls", "command rises")

Samples = NDArray[np.float64]


def plot_static_map(found: "StaticMap") -> Plot:
    """The curve of a map with 95 % intervals over the scatter of its samples, and what is fitted to it.

    Points of sweeps have a colour for each direction of the command; pressures that decay are shown over
    time, with those of the balance.

    Args:
        found: the map.
    """
    with style():
        fig = figure(HEIGHT)
        axis = fig.subplots()
        axis.margins(MARGIN, 2.0 * MARGIN)
        if found.kind == "decay":
            draw_decay(axis, found)
        else:
            draw_curve(axis, found)
        axis.legend(loc="best")
    return fig


def draw_curve(axis: Axes, found: "StaticMap") -> None:
    """The second variable over the first."""
    curve = found.curve
    name_x, name_y = list(map(str, curve.data_vars))[:2]
    x, y = scaled(axis, found, name_x, name_y)
    deviation, half = curve[f"{name_y}_deviation"].values * y, curve[f"{name_y}_half"].values * y
    ways = curve["rising"].values if "rising" in curve else np.full(curve.sizes["point"], -1.0)
    for way in np.unique(ways)[::-1]:
        on = ways == way
        colour = PALETTE[int(max(way, 0.0))]
        places, values = x * curve[name_x].values[on], y * curve[name_y].values[on]
        bar: dict[str, Any] = {"linestyle": "", "color": colour, "zorder": 2}
        axis.errorbar(places, values, deviation[on], elinewidth=3.0, alpha=0.25, **bar)
        label = "mean, 95 % interval and scatter" if way < 0.0 else DIRECTIONS[int(way)]
        axis.errorbar(
            places, values, half[on], marker="o", markersize=DOT, elinewidth=0.8, label=label, **bar
        )
    for line in found.lines:
        axis.plot(x * line.x, y * line.y, color=GREY, linewidth=1.0, label=line.label or None, zorder=3)


def scaled(axis: Axes, found: "StaticMap", *names: str) -> list[float]:
    """Label both axes; the factors to their units."""
    factors = []
    for name, which in zip(names, "xy", strict=True):
        row = found.curve[name]
        unit, factor = axis_unit(row.attrs["units"], largest([row.values]))
        said = row.attrs["long_name"].replace("p_A - p_B", "$p_A - p_B$")
        axis.set(**{f"{which}label": f"{said} [{unit}]"})
        factors.append(factor)
    return factors


def draw_decay(axis: Axes, found: "StaticMap") -> None:
    """Both pressures over time, log after log."""
    curve = found.curve
    x, y = scaled(axis, found, "time", "pressure_a")
    axis.set_ylabel(axis.get_ylabel().replace("pressure a", "pressure"))
    for i, chamber in enumerate("ab"):
        for number in np.unique(curve["log"].values):
            on = curve["log"].values == number
            time, first = x * curve["time"].values[on], number == curve["log"].values[0]
            shown = f"$p_{chamber.upper()}$ measured" if first else None
            measured = y * curve[f"pressure_{chamber}"].values[on]
            axis.plot(
                time,
                measured,
                ".",
                color=PALETTE[i],
                alpha=0.35,
                markersize=2.0,
                label=shown,
                rasterized=True,
            )
            fitted = y * curve[f"pressure_{chamber}_fitted"].values[on]
            label = "balance" if first and chamber == "b" else None
            axis.plot(time, fitted, color=GREY, linewidth=1.0, label=label)
