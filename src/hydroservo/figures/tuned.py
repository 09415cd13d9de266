"""The picture of a search for gains: the metric of each loop before and after."""

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydroservo.figures.ranges import axis_unit
from hydroservo.figures.style import GREY, PALETTE, figure, style
from hydroservo.formatting import number
from hydroservo.runs.tuning import Tuned

__all__ = ["plot_tuned"]

ROW = 0.34  # inch, of a loop
MARGIN = 1.6  # factor of the axis beyond the outermost dots
DOT = 6.0  # points


def plot_tuned(found: Tuned) -> Figure:
    """The metric of each loop with its own values and with the best ones, a line each.

    A loop that diverged before stands at the right edge, with a triangle.

    Args:
        found: what :func:`~hydroservo.tune` returned.
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
        axis.xaxis.set_major_formatter(number_ticks)
        axis.xaxis.set_minor_formatter(number_ticks)
        axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    return fig


def number_ticks(value: float, _: float) -> str:
    """A tick with a plain number where its first digit is 1, 2 or 5."""
    return number(value, 1) if value > 0.0 and f"{value:e}"[0] in "125" else ""


def draw_row(axis: Axes, row: int, before: float, after: float, edge: float) -> None:
    """The two dots of a loop, and a line from the first to the second."""
    start = min(before, edge)
    axis.plot([start, after], [row, row], color=GREY, linewidth=1.2, zorder=1)
    marker = "o" if before < math.inf else ">"
    labels = ("before", "after") if row == 0 else ("", "")
    dot = {"linestyle": "", "markersize": DOT, "clip_on": False}
    axis.plot([start], [row], marker=marker, color=GREY, label=labels[0], **dot)  # type: ignore[arg-type]
    axis.plot([after], [row], marker="o", color=PALETTE[0], label=labels[1], **dot)  # type: ignore[arg-type]
