"""The pictures of a linear model: its frequency responses, beside measured ones, and its poles."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MultipleLocator
from numpy.typing import NDArray

from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.formatting import quantity
from hydroservo.figures.style import GREY, PALETTE, Plot, figure, style
from hydroservo.linear.margins import MARGIN_LABELS, formatted_margin

if TYPE_CHECKING:
    from hydroservo.linear import Linearization

Response = NDArray[np.complex128]
Numbers = NDArray[np.float64]

HEIGHT = 5.6  # inch
ROWS = (2.2, 1.6, 0.7)  # of magnitude, phase and coherence
COHERENT = 0.95  # below it a measured point is drawn pale
PALE = 0.25
SHADES = 0.15, 0.85  # of the colours of several points
PREFIXES = {1e6: "M", 1e3: "k", 1.0: "", 1e-3: "m", 1e-6: "µ", 1e-9: "n", 1e-12: "p"}
DOTS = {"simulation": 9.0, "log": 3.0}  # their areas [pt^2]
HALF = 10.0  # degrees by which a rise of half a turn counts as a fall
QUARTER = 90.0  # degrees between ticks
POLES_HEIGHT = 3.4  # inch
DAMPING = (0.1, 0.3, 0.5, 0.7)  # of the lines that are drawn
MARGIN = 1.15  # of an axis, beyond the outermost pole
FAINT = {"color": GREY, "linewidth": 0.6, "linestyle": ":", "zorder": 1}


class ResponseColumn(NamedTuple):
    """One column of panels: a response, and another beside it."""

    title: str
    name: str
    beside: str | None = None


OPEN, CLOSED = ResponseColumn("open loop", "open"), ResponseColumn("closed loop", "closed")
COLUMNS = (OPEN, CLOSED, ResponseColumn("compliance", "compliance", "open_compliance"))
WITH_LOGS = (ResponseColumn("machine", "machine"), OPEN, CLOSED)  # for logs tell nothing of the compliance


def plot_bode(data: xr.Dataset) -> Plot:
    """Magnitude, phase and coherence of the open loop, the closed loop, and the way it gives to its load.

    Lines are the linear model, dots were measured; pale ones have a coherence below 0.95. Where the data hold
    several points, each has a line, and nothing was measured on the simulation. With recorded logs the
    machine by its command takes the place of the compliance.

    Args:
        data: what :func:`~hydroservo.bode` returned, or several of these along ``point``.
    """
    with style():
        fig = figure(HEIGHT)
        rows = ROWS if {"tone", "recorded"} & set(data.coords) else ROWS[:2]
        columns = WITH_LOGS if "recorded" in data.coords else COLUMNS
        axes = fig.subplots(len(rows), len(columns), sharex=True, height_ratios=rows, squeeze=False)
        for place, column in enumerate(columns):
            draw_column(data, axes[:, place].tolist(), column)
            axes[0, place].set_title(f"({'abc'[place]}) {column.title}", loc="left", fontsize=8)
            axes[-1, place].set_xlabel("frequency [Hz]")
        for axis, label in zip(axes[1:, 0], ("phase [°]", "coherence"), strict=False):
            axis.set_ylabel(label)
        add_bode_legend(fig, data)
        fig.align_ylabels()
    return fig


def draw_column(data: xr.Dataset, axes: Sequence[Axes], column: ResponseColumn) -> None:
    """The panels of a response, one above the other."""
    top, middle = axes[0], axes[1]
    unit, scale = in_command_unit(data[column.name].attrs["units"])
    if unit:
        largest = float(np.abs(data[column.name]).max())
        prefix, unit = readable_size(unit, scale * largest)
        scale *= prefix
        top.set_yscale("log")
        top.set_ylabel(f"[{unit}]")
    else:
        top.set_ylabel("magnitude [dB]" if column.name == "open" else "[dB]")
    for points, colour in curves_of(data):
        for name, line in ((column.beside, ":"), (column.name, "-")):
            if name:
                f, response = points["frequency"].values, points[name].values
                shown = GREY if name == column.beside else colour
                top.plot(f, response_size(response, scale, bool(unit)), line, color=shown)
                middle.plot(f, degrees(response), line, color=shown)
    if "tone" in data.coords:
        draw_measured(data, axes, column, scale)
    if f"{column.name}_recorded" in data:
        draw_recorded(data, axes, column.name, scale)
    top.set_xscale("log")
    top.xaxis.set_major_formatter(FuncFormatter(lambda f, _: f"{f:g}"))
    middle.yaxis.set_major_locator(multiples(middle))
    if "point" not in data.dims:
        mark_bandwidth(data, axes, column.name)


def draw_measured(data: xr.Dataset, axes: Sequence[Axes], column: ResponseColumn, scale: float) -> None:
    """What was measured as dots, and its coherence below."""
    coherence = data[f"{column.name}_coherence"]
    for name, colour in ((column.beside, GREY), (column.name, PALETTE[0])):
        if name:
            draw_dots(
                axes, data[name], data[f"{name}_measured"], coherence, scale, colour, DOTS["simulation"]
            )


def draw_recorded(data: xr.Dataset, axes: Sequence[Axes], name: str, scale: float) -> None:
    """What logs tell of a response, each in its colour."""
    line = data[name].isel(point=0) if "point" in data.dims else data[name]
    for log, colour in coloured_logs(data):
        own = data.isel(
            recorded=np.flatnonzero((data["log"] == log) & data[f"{name}_recorded_coherence"].notnull())
        )
        response, coherence = own[f"{name}_recorded"], own[f"{name}_recorded_coherence"]
        draw_dots(axes, line, response, coherence, scale, colour, DOTS["log"])


def draw_dots(
    axes: Sequence[Axes],
    line: xr.DataArray,
    response: xr.DataArray,
    coherence: xr.DataArray,
    scale: float,
    colour: str,
    area: float,
) -> None:
    """A measured response as dots near a line, pale where it is not coherent, and its coherence below."""
    f, values = next(iter(response.coords.values())).values, response.values
    near = np.interp(np.log(f), np.log(line["frequency"]), degrees(line.values))
    phase = near + (np.degrees(np.angle(values)) - near + 180.0) % 360.0 - 180.0  # of its own turn
    colours = [to_rgba(colour, 1.0 if one >= COHERENT else PALE) for one in coherence.values]
    for axis, shown in ((axes[0], response_size(values, scale, bool(line.attrs["units"]))), (axes[1], phase)):
        axis.scatter(f, shown, s=area, color=colours, linewidths=0, zorder=3)
    axes[2].scatter(f, coherence.values, s=DOTS["log"], color=colour, linewidths=0)
    axes[2].set_ylim(0.0, 1.05)


def coloured_logs(data: xr.Dataset) -> list[tuple[str, str]]:
    names = list(dict.fromkeys(data["log"].values.tolist())) if "log" in data.coords else []
    return [(name, PALETTE[1 + i % (len(PALETTE) - 1)]) for i, name in enumerate(names)]


def mark_bandwidth(data: xr.Dataset, axes: Sequence[Axes], name: str) -> None:
    """Crossover and bandwidth, where the response has them."""
    if name == "open":
        draw_level(axes[0], 0.0)
        draw_level(axes[1], -180.0)
        write_lines(axes[0], margin_texts(data) if data["stable"] else ["unstable for small motions"])
        for w in data["gain_crossovers"].values[-1:]:
            if math.isfinite(data["phase_margin"]):
                draw_upright(axes[:2], w / (2.0 * math.pi))
    if name == "closed":
        draw_level(axes[0], -20.0 * math.log10(math.sqrt(2.0)))
        draw_level(axes[1], -QUARTER)
        said = [
            f"{text} at {quantity(float(data[key]), 'Hz')}"
            for key, text in (("bandwidth", "\N{MINUS SIGN}3 dB"), ("bandwidth_90", "\N{MINUS SIGN}90°"))
            if math.isfinite(data[key])
        ]
        write_lines(axes[0], said)


def margin_texts(data: xr.Dataset) -> list[str]:
    """The margins that there are and the onset of oscillation, a line each."""
    shown = ("gain_margin", "phase_margin", "disk_margin", "oscillation_gain")
    known = [name for name in shown if not math.isnan(data[name])]
    return [
        f"{MARGIN_LABELS[name][0]} {formatted_margin(float(data[name]), MARGIN_LABELS[name][1], '')}"
        for name in known
    ]


def draw_level(axis: Axes, value: float) -> None:
    axis.axhline(value, color=GREY, linewidth=0.7, dashes=(4, 3), zorder=1)


def draw_upright(axes: Sequence[Axes], frequency: float) -> None:
    for axis in axes:
        axis.axvline(frequency, color=GREY, linewidth=0.7, dashes=(4, 3), zorder=1)


def write_lines(axis: Axes, lines: list[str]) -> None:
    clear = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
    said = "\n".join(lines)
    axis.text(0.04, 0.04, said, transform=axis.transAxes, fontsize=6.5, color=GREY, va="bottom", bbox=clear)


def response_size(response: Response, scale: float, unit: bool) -> Numbers:
    """The size of a response: in its unit, or in decibels."""
    size: Numbers = np.abs(response)
    with np.errstate(divide="ignore"):  # nothing is drawn of a response of 0
        return scale * size if unit else 20.0 * np.log10(size)


def degrees(response: Response) -> Numbers:
    """The phase without jumps but half a turn down where nothing damps, its first value near -45 degrees."""
    angle = np.degrees(np.angle(response))
    turned = (np.diff(angle) + 180.0 + HALF) % 360.0 - 180.0 - HALF
    phase = angle[0] + np.concatenate([[0.0], np.cumsum(turned)])
    return np.asarray(phase - 360.0 * np.round((phase[0] + 45.0) / 360.0))


def multiples(axis: Axes) -> MultipleLocator:
    """Ticks at multiples of 90 degrees, or 45 where there are few."""
    low, high = axis.get_ylim()
    steps = max(math.ceil((high - low) / (5.0 * QUARTER)), 1)
    return MultipleLocator(QUARTER * steps if high - low > 2.0 * QUARTER else 0.5 * QUARTER)


def readable_size(unit: str, largest: float) -> tuple[float, str]:
    """The factor, and the unit with a prefix, in which a response is near 1."""
    power = min(PREFIXES, key=lambda one: abs(math.log10(largest / one)))
    return 1.0 / power, f"{PREFIXES[power]}{unit}"


def curves_of(data: xr.Dataset) -> list[tuple[xr.Dataset, Any]]:
    """The points of a table, each with a colour."""
    if "point" not in data.dims:
        return [(data, PALETTE[0])]
    import matplotlib as mpl

    shades = np.linspace(*SHADES, data.sizes["point"])
    return [(data.isel(point=i), mpl.colormaps["viridis"](shade)) for i, shade in enumerate(shades)]


def add_bode_legend(fig: Figure, data: xr.Dataset) -> None:
    """One legend above all panels."""
    if "point" in data.dims:
        unit = data["point"].attrs["units"]
        labels = [quantity(float(one), unit) for one in data["point"].values]
        handles = [Line2D([], [], color=colour) for _, colour in curves_of(data)]
    else:
        handles, labels = [Line2D([], [], color=PALETTE[0])], ["linear model"]
        if "tone" in data.coords:
            handles.append(Line2D([], [], color=PALETTE[0], marker=".", linestyle=""))
            labels.append("measured on the simulation")
    for log, colour in coloured_logs(data):
        handles.append(Line2D([], [], color=colour, marker=".", linestyle=""))
        labels.append(Path(log).name)
    if "recorded" not in data.coords:
        handles.append(Line2D([], [], color=GREY, linestyle=":"))
        labels.append("command held")
    fig.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 6))


def plot_poles(model: "Linearization") -> Plot:
    """The poles of a linear model, with lines of equal damping; those that are not stable are red.

    In continuous time s = -zeta w ± j w sqrt(1 - zeta^2); of a sampled model z = e^(s h), inside the unit
    circle where it is stable.
    """
    with style():
        fig = figure(POLES_HEIGHT, width=1.3 * POLES_HEIGHT)
        axis = fig.subplots()
        poles = model.poles
        lost = np.abs(poles) > 1.0 if model.period else poles.real > 0.0
        (draw_z_plane if model.period else draw_s_plane)(axis, poles)
        for which, colour in ((~lost, PALETTE[0]), (lost, PALETTE[1])):
            axis.plot(poles.real[which], poles.imag[which], "x", color=colour, markeredgewidth=1.6)
        axis.set_title(f"poles of the {model.unit}", loc="left")
    return fig


def draw_s_plane(axis: Axes, poles: np.ndarray) -> None:
    """Axes through s = 0, and rays of equal damping."""
    reach = MARGIN * float(np.abs(poles).max(initial=0.0)) or 1.0
    for zeta in DAMPING:
        x, y = -zeta * reach, reach * np.sqrt(1.0 - zeta**2)
        for sign in (1.0, -1.0):
            axis.plot([0.0, x], [0.0, sign * y], **FAINT)  # type: ignore[arg-type]
        axis.annotate(f"{zeta:g}", (x, y), color=GREY, fontsize=7, ha="right", va="bottom")
    axis.axvline(0.0, color=GREY, linewidth=0.8)
    right = MARGIN * max(float(poles.real.max(initial=0.0)), 0.1 * reach)
    axis.set(xlim=(-MARGIN * reach, right), ylim=(-MARGIN * reach, MARGIN * reach))
    axis.set(xlabel="Re s [1/s]", ylabel="Im s [rad/s]")


def draw_z_plane(axis: Axes, poles: np.ndarray) -> None:
    """The unit circle, and curves of equal damping inside it."""
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    axis.plot(np.cos(turn), np.sin(turn), color=GREY, linewidth=0.8)
    angle = np.linspace(0.0, np.pi, 181)
    for zeta in DAMPING:
        z = np.exp((-zeta / np.sqrt(1.0 - zeta**2) + 1j) * angle)
        for half in (z, z.conj()):
            axis.plot(half.real, half.imag, **FAINT)  # type: ignore[arg-type]
        axis.annotate(f"{zeta:g}", (z[60].real, z[60].imag), color=GREY, fontsize=7, ha="center")
    reach = MARGIN * max(1.0, float(np.abs(poles).max(initial=0.0)))
    axis.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="Re z", ylabel="Im z", aspect="equal")
