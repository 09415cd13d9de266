"""Pictures of an identification: the log as it was understood, how it is met, and static maps."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from hydroservo.figures.panels import axis_unit, largest_size
from hydroservo.figures.style import GREY, PALETTE, Plot, figure, style
from hydroservo.identification.log import INPUTS, SIGNALS

if TYPE_CHECKING:
    from hydroservo.identification import LogFit
    from hydroservo.identification.maps import StaticMap
    from hydroservo.identification.segments import UnderstoodLog

HEIGHT = 1.35  # inch, of a panel
SUFFIX = "_simulated"
MOST = 20_000  # points of a curve; longer ones become pixels inside an SVG
MAP_HEIGHT = 3.2  # inch
CHARACTERISTIC_HEIGHT = 4.4  # inch
ABOUT_NULL = 1.0  # dead bands shown on either side of one
LEAST_ABOUT = 0.1  # of the largest command, shown on either side of null
HEADROOM = 1.3  # times the ends of what is shown
MARGIN = 0.03  # of the axes
DOT, SMALL_DOT = 3.2, 2.0  # points
DIRECTIONS = ("command falls", "command rises")

Samples = NDArray[np.float64]


def plot_log(whole: "UnderstoodLog") -> Plot:
    """Each signal of a log over time as it was understood; what was left out is marked."""
    log = whole.log
    parts = [{**one.inputs, **one.measured} for one in whole.segments]
    names = [name for name in SIGNALS if name in parts[0]]
    with style():
        fig, axes = signal_panels(names)
        for axis, name in zip(axes, names, strict=True):
            unit, factor = axis_unit(SIGNALS[name].unit, largest_size([part[name] for part in parts]))
            for segment, part in zip(whole.segments, parts, strict=True):
                dense = segment.samples > MOST
                axis.plot(segment.time, factor * part[name], color=PALETTE[0], rasterized=dense)
            out = whole.spikes.get(name)
            if out is not None and out.any():
                shown = factor * log.signals[name][out]
                label = "stands out, and is played" if name in INPUTS else "stands out, and is left out"
                axis.plot(log.time[out], shown, "x", color=PALETTE[1], markersize=3.5, label=label)
                axis.legend(loc="upper right")
            axis.set_ylabel(f"{name.replace('_', ' ')}\n[{unit}]")
        label_time(axes, log.name)
    return fig


def plot_fit(fit: "LogFit") -> Plot:
    """Measured and simulated signals of a log over time, and what is left between them."""
    with style():
        fig, axes = signal_panels([name for name in fit.signals for _ in range(2)])
        for i, (name, one) in enumerate(fit.signals.items()):
            upper, lower = axes[2 * i : 2 * i + 2]
            measured, shown = fit.data[name].values, fit.data[name + SUFFIX].values
            unit, factor = axis_unit(one.unit, largest_size([measured]))
            dense = fit.data.time.size > MOST
            upper.plot(*with_gaps(fit.data, name, factor), color=GREY, label="measured", rasterized=dense)
            simulated = with_gaps(fit.data, name + SUFFIX, factor)
            upper.plot(*simulated, color=PALETTE[1], label="simulated", rasterized=dense)
            upper.set_ylabel(f"{name.replace('_', ' ')}\n[{unit}]")
            unit, factor = axis_unit(one.unit, largest_size([measured - shown], 0.01))
            left = fit.data.assign(left=fit.data[name] - fit.data[name + SUFFIX])
            lower.plot(*with_gaps(left, "left", factor), color=PALETTE[0], linewidth=0.6, rasterized=dense)
            limit = factor * max(largest_size([measured - shown], 0.01), 1e-300)
            lower.set_ylim(-1.3 * limit, 1.3 * limit)
            lower.set_ylabel(f"left over\n[{unit}]")
        label_time(axes, fit.understood.log.name)
        fig.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return fig


def signal_panels(names: Sequence[str]) -> tuple[Plot, list[Axes]]:
    """A figure with a panel for each name, one above the other on one time."""
    fig = figure(HEIGHT * len(names) + 0.4)
    axes = fig.subplots(len(names), 1, sharex=True, squeeze=False)
    return fig, list(axes[:, 0])


def with_gaps(data: xr.Dataset, name: str, factor: float) -> tuple[np.ndarray, np.ndarray]:
    """A signal over time, with a break where the log has a gap."""
    time, values = data.time.values, factor * data[name].values
    gaps = np.flatnonzero(np.diff(time) > 1.5 * np.median(np.diff(time))) + 1
    return np.insert(time, gaps, np.nan), np.insert(values, gaps, np.nan)


def label_time(axes: Sequence[Axes], title: str) -> None:
    axes[0].set_title(title.replace("$", r"\$"), loc="left")
    axes[-1].set_xlabel("time [s]")


def plot_static_map(found: "StaticMap") -> Plot:
    """The curve of a map with 95 % intervals over the scatter of its samples, and what is fitted to it.

    Points of sweeps have a colour for each direction of the command; pressures that decay are shown over
    time, with those of the balance. A characteristic is shown about null as well, with its dead band and how
    far both directions of the command lie apart.

    Args:
        found: the map.
    """
    if found.characteristic is not None:
        return plot_characteristic(found, found.characteristic)
    with style():
        fig = figure(MAP_HEIGHT)
        axis = fig.subplots()
        axis.margins(MARGIN, 2.0 * MARGIN)
        if found.kind == "decay":
            draw_decay(axis, found)
        else:
            draw_map_curve(axis, found)
        axis.legend(loc="best")
    return fig


def plot_characteristic(found: "StaticMap", table: xr.Dataset) -> Plot:
    """Both branches and the table, whole and about null, and how far the branches lie apart."""
    name = table.attrs["quantity"]
    command, answer = table["command"].values, table[name].values
    null = command[answer == 0.0]
    with style():
        fig = figure(CHARACTERISTIC_HEIGHT)
        axes = fig.subplot_mosaic([["whole", "null"], ["apart", "apart"]], height_ratios=[3.0, 1.0])
        for axis, size in ((axes["whole"], SMALL_DOT), (axes["null"], DOT)):
            axis.margins(MARGIN, 2.0 * MARGIN)
            draw_map_curve(axis, found, size)
        unit, factor = axis_unit(table[name].attrs["units"], largest_size([found.curve[name].values]))
        axes["whole"].set(ylabel=f"{name} [{unit}]", title="whole")
        reach = max(ABOUT_NULL * float(np.ptp(null)), LEAST_ABOUT * float(command[-1]))
        ends = np.array([null[0] - reach, null[-1] + reach])
        low, high = HEADROOM * factor * np.interp(ends, command, answer)
        axes["null"].set(xlim=ends, ylim=(low, high), ylabel="", title="about null")
        draw_width(axes["apart"], command, table["hysteresis"].values)
        for axis in axes.values():
            if null.size > 1:
                axis.axvspan(null[0], null[-1], color=GREY, alpha=0.15, linewidth=0.0, label="dead band")
        axes["whole"].legend(loc="upper left")
    return fig


def draw_width(axis: Axes, command: Samples, width: Samples) -> None:
    """How far both directions of the command lie apart at each point where that is known."""
    known = width[np.isfinite(width)]
    unit, factor = axis_unit("V", largest_size([known]))
    axis.plot(command, factor * width, "o-", color=GREY, markersize=DOT, linewidth=0.8)
    axis.set(xlabel="command [V]", ylabel=f"apart [{unit}]", xlim=(command[0], command[-1]))
    if known.size:
        axis.set_ylim(HEADROOM * factor * min(known.min(), 0.0), HEADROOM * factor * max(known.max(), 1e-6))


def draw_map_curve(axis: Axes, found: "StaticMap", size: float = DOT) -> None:
    """The second variable over the first, with marks of a size in points."""
    curve = found.curve
    name_x, name_y = list(map(str, curve.data_vars))[:2]
    x, y = label_map_axes(axis, found, name_x, name_y)
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
            places, values, half[on], marker="o", markersize=size, elinewidth=0.8, label=label, **bar
        )
    for line in found.lines:
        axis.plot(x * line.x, y * line.y, color=GREY, linewidth=1.0, label=line.label or None, zorder=3)


def label_map_axes(axis: Axes, found: "StaticMap", *names: str) -> list[float]:
    """Label both axes; the factors to their units."""
    factors = []
    for name, which in zip(names, "xy", strict=True):
        row = found.curve[name]
        unit, factor = axis_unit(row.attrs["units"], largest_size([row.values]))
        said = row.attrs["long_name"].replace("p_A - p_B", "$p_A - p_B$")
        axis.set(**{f"{which}label": f"{said} [{unit}]"})
        factors.append(factor)
    return factors


def draw_decay(axis: Axes, found: "StaticMap") -> None:
    """Both pressures over time, log after log."""
    curve = found.curve
    x, y = label_map_axes(axis, found, "time", "pressure_a")
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
