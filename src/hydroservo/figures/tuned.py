"""The pictures of a search for gains: the metric of each loop before and after, and what it costs."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from hydroservo.core.formatting import number
from hydroservo.figures.panels import axis_unit
from hydroservo.figures.style import GREY, PALETTE, Plot, figure, style

if TYPE_CHECKING:
    from hydroservo.runs.tuned import TriedValues, Tuned

ROW = 0.34  # inch, of a loop
MARGIN = 1.6  # factor of the axis beyond the outermost dots
DOT = 6.0  # points
HEIGHT = 3.0  # inch, of a front
FRONT = "#8a8a8a"
MARKS = {  # of what is compared on a front: marker, size, colour; a larger one shows below a smaller one
    "before": ("s", 8.5, GREY),
    "first guess": ("D", 7.0, PALETTE[1]),
    "after": ("o", 5.0, PALETTE[0]),
}
EDGE = 0.06  # of a front's axes beyond the outermost points, by the logarithm
NARROW, ALONE = 1.1, 1.5  # times the least, which an axis spans at least; and about a single point
FEW = 8.0  # times the least number on an axis, up to which its ticks are evenly spaced
MANY = 1e3  # times, from which they are powers of ten


def plot_tuned(found: "Tuned") -> Plot:
    """The metric of each loop with its own values and with the best ones, a line each.

    A loop that diverged before stands at the right edge, with a triangle.
    """
    unit = found.tables[0][found.metric].attrs["units"]
    finite = [value for value in (*found.before, *found.after) if 0.0 < value < math.inf]
    label, factor = axis_unit(unit, max(finite, default=1.0))
    edge = factor * MARGIN * max(finite, default=1.0)
    with style():
        fig = figure(0.9 + ROW * len(found.names))
        axis = fig.subplots()
        for row, pair in enumerate(zip(found.before, found.after, strict=True)):
            draw_row(axis, row, factor * pair[0], factor * pair[1], edge)
        axis.set_yticks(range(len(found.names)), [name.replace("$", r"\$") for name in found.names])
        axis.set_ylim(len(found.names) - 0.5, -0.5)
        axis.set_xscale("log")
        axis.set_xlim(factor * min(finite, default=1.0) / MARGIN, edge)
        axis.grid(axis="y", visible=False)
        axis.set_xlabel(f"{found.metric.replace('_', ' ')} [{label}]" if label else found.metric)
        set_ticks(axis.xaxis)
        axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    return fig


def draw_row(axis: Axes, row: int, before: float, after: float, edge: float) -> None:
    """The two dots of a loop, and a line from the first to the second."""
    start = min(before, edge)
    axis.plot([start, after], [row, row], color=GREY, linewidth=1.2, zorder=1)
    marker = "o" if before < math.inf else ">"
    labels = ("before", "after") if row == 0 else ("", "")
    dot = {"linestyle": "", "markersize": DOT, "clip_on": False}
    axis.plot([start], [row], marker=marker, color=GREY, label=labels[0], **dot)  # type: ignore[arg-type]
    axis.plot([after], [row], marker="o", color=PALETTE[0], label=labels[1], **dot)  # type: ignore[arg-type]


def plot_front(found: "Tuned") -> Plot:
    """The least error by the command's activity, of the candidates within the bounds.

    The own values, the first guess and the best values are marked, hollow where they are outside the bounds.
    What diverged, or did not move the command, is left out.

    Args:
        found: what :func:`~hydroservo.tune` returned.
    """
    front = sorted(filter(is_shown, found.front), key=lambda one: one.activity)
    compared = {
        name: one
        for name, one in zip(MARKS, (found.own, found.guess, found.best), strict=True)
        if one is not None and is_shown(one)
    }
    errors = [one.error for one in (*front, *compared.values())]
    activities = [one.activity for one in (*front, *compared.values())]
    y_label, y = axis_unit(found.tables[0][found.metric].attrs["units"], max(errors, default=1.0))
    x_label, x = axis_unit("V", max(activities, default=1.0))
    with style():
        fig = figure(HEIGHT)
        axis = fig.subplots()
        axis.set(xscale="log", yscale="log", xlabel=f"total variation of the command [{x_label}]")
        axis.set_ylabel(f"{found.metric.replace('_', ' ')} [{y_label}]".removesuffix(" []"))
        axis.set(xlim=log_extent(activities, x), ylim=log_extent(errors, y))
        set_ticks(axis.xaxis)
        set_ticks(axis.yaxis)
        if front:
            line = [[x * one.activity for one in front], [y * one.error for one in front]]
            axis.plot(*line, "o-", color=FRONT, ms=3.2, lw=0.9, drawstyle="steps-post", label="least error")
        for name, one in compared.items():
            draw_mark(axis, name, x * one.activity, y * one.error, within=one.within)
        handles = axis.get_legend_handles_labels()[0]
        if not all(one.within for one in compared.values()):
            handles.append(hollow_mark("outside the bounds"))
        axis.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=max(len(handles), 1))
    return fig


def is_shown(one: "TriedValues") -> bool:
    """Whether a point has a place on logarithmic axes."""
    return 0.0 < one.error < math.inf and 0.0 < one.activity < math.inf


def draw_mark(axis: Axes, name: str, activity: float, error: float, *, within: bool) -> None:
    """The mark of values that are compared."""
    marker, size, colour = MARKS[name]
    face = colour if within else "white"
    (drawn,) = axis.plot([activity], [error], color=colour, label=name, zorder=4, clip_on=False)
    drawn.set(marker=marker, markersize=size, linestyle="", markerfacecolor=face)


def hollow_mark(label: str) -> Line2D:
    """What a legend shows for hollow points."""
    return Line2D([], [], marker="o", linestyle="", color=GREY, markerfacecolor="white", label=label)


def log_extent(values: Sequence[float], factor: float) -> tuple[float, float]:
    """The range of a logarithmic axis that holds all values, with a margin."""
    low, high = min(values, default=1.0), max(values, default=1.0)
    span = high / low
    beyond = max(span ** (1.0 + 2.0 * EDGE), NARROW if span > 1.0 else ALONE) / span
    return factor * low / math.sqrt(beyond), factor * high * math.sqrt(beyond)


def set_ticks(axis: Axis) -> None:
    """Ticks of a logarithmic axis at round numbers, however much it spans."""
    low, high = axis.get_view_interval()
    if high < FEW * low:
        axis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
        axis.set_major_formatter(lambda value, _: f"{value:g}")
    else:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < MANY * low else (1.0,)))
        axis.set_major_formatter(lambda value, _: number(value, 1))
    axis.set_minor_locator(NullLocator())
