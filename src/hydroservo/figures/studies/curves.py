"""What a search of more candidates buys: error on test against the budget."""

import math
from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullLocator

from hydroservo.figures.studies.layout import fix_layout
from hydroservo.figures.studies.looks import distinct, family_colours
from hydroservo.figures.studies.scales import plain_log, spread_out
from hydroservo.figures.style import figure, style
from hydroservo.formatting import readable_unit

__all__ = ["BudgetCurve", "plot_curves"]

TOGETHER = 7  # laws in one panel; more have a panel a family
ACROSS = 3  # panels
MARGIN = 1.04
LINES = ("-", "--", ":", "-.")  # of the laws of one family
NAME = 7  # points
GAP = 1.3  # of the size of a name, between names
LEAD = 12.0  # pixels from a panel to its names


class BudgetCurve(NamedTuple):
    """A law's error after so many candidates."""

    law: str
    family: str
    budgets: Sequence[int]
    median: Sequence[float]  # of searches [unit of the metric]
    low: Sequence[float]  # their lower quartile
    high: Sequence[float]  # and their upper; inf where searches are lost


def plot_curves(curves: Sequence[BudgetCurve], families: Sequence[str], metric: str, unit: str) -> Figure:
    """Error on test against candidates tried, a line a law: median of the searches, and a band of quartiles.

    Names stand at the ends of lines. Many laws have a panel for each family, with the others pale behind.

    Args:
        curves: of one cell, or of ratios over all of them.
        families: all of the study, in the order that gives them their colours.
        metric: what the error is.
        unit: of the error.
    """
    finite = [
        one for curve in curves for one in (*curve.low, *curve.high, *curve.median) if math.isfinite(one)
    ]
    label, factor = readable_unit(unit, max(finite))
    low, high = factor * min(finite) / MARGIN, factor * max(finite) * MARGIN
    groups = [""] if len(curves) <= TOGETHER else distinct(curve.family for curve in curves)
    rows = math.ceil(len(groups) / ACROSS)
    with style(maths=False):
        fig = figure(3.4 if len(groups) == 1 else 0.3 + 1.9 * rows)
        across = min(len(groups), ACROSS)
        panels = fig.subplots(rows, across, squeeze=False, sharex=True, sharey=True)
        for axis, group in zip(panels.flat, groups, strict=False):
            plain_log(axis.yaxis, low, high)
            own = [curve for curve in curves if not group or curve.family == group]
            draw_panel(axis, curves, own, family_colours(families), factor)
            axis.set_title(group, fontsize="medium")
        for axis in panels.flat[len(groups) :]:
            axis.set_axis_off()
        fig.supxlabel("candidates tried", fontsize="medium")
        fig.supylabel(f"{metric} [{label}]" if label else metric, fontsize="medium")
        name_lines(fig, [*panels.flat][: len(groups)])
    return fig


def draw_panel(
    axis: Axes,
    every: Sequence[BudgetCurve],
    own: Sequence[BudgetCurve],
    colours: Mapping[str, str],
    factor: float,
) -> None:
    budgets = sorted({budget for curve in every for budget in curve.budgets})
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(FixedLocator(budgets))
    axis.xaxis.set_minor_locator(NullLocator())
    shown = budgets[::-2] if len(own) < len(every) else budgets
    axis.set_xticks(shown, [str(budget) for budget in shown])
    axis.set_xlim(budgets[0], budgets[-1])
    for curve in every:
        if curve not in own:
            axis.plot(
                curve.budgets,
                [factor * one for one in curve.median],
                color="#dfe3e6",
                linewidth=0.8,
                zorder=1,
            )
    met: list[str] = []
    begin = len(shared_beginning([curve.law for curve in own])) if len(own) < len(every) else 0
    for curve in own:
        line = LINES[met.count(curve.family) % len(LINES)]
        met.append(curve.family)
        draw_curve(axis, curve._replace(law=curve.law[begin:]), colours[curve.family], line, factor)


def shared_beginning(names: Sequence[str]) -> str:
    """What several names begin with, up to a sign or space between words; nothing of one name."""
    if len(names) < 2:
        return ""
    shared = "".join(
        sign for sign, *_ in takewhile(lambda one: len(set(one)) == 1, zip(*names, strict=False))
    )
    found = shared[: max((shared.rfind(sign) for sign in "+ /-"), default=-1) + 1]
    return "" if found in names else found


def draw_curve(axis: Axes, curve: BudgetCurve, colour: str, line: str, factor: float) -> None:
    """A line with its band, and its name for :func:`name_lines`."""
    low, high = ([factor * min(one, 1e9) for one in ends] for ends in (curve.low, curve.high))
    axis.fill_between(curve.budgets, low, high, color=colour, alpha=0.16, linewidth=0)
    (drawn,) = axis.plot(curve.budgets, [factor * one for one in curve.median], line, color=colour)
    drawn.set(label=curve.law, linewidth=1.4, marker="o", markersize=2.4, linestyle=line, clip_on=False)


def name_lines(fig: Figure, panels: Sequence[Axes]) -> None:
    """Write the name of each line at its end, and where names would touch move them apart."""
    for axis in panels:
        named = [line for line in axis.lines if not str(line.get_label()).startswith("_")]
        for line in named:  # so that the layout leaves room for them
            place_name(axis, line, 0.5)
    fix_layout(fig)
    for axis in panels:
        named = [line for line in axis.lines if not str(line.get_label()).startswith("_")]
        gap = GAP * NAME * fig.dpi / 72.0 / axis.bbox.height
        wanted = [share_of(axis, line) for line in named]
        for text in [*axis.texts]:
            text.remove()
        for line, where in zip(named, spread_out(wanted, gap, 0.0, 1.0), strict=True):
            place_name(axis, line, where)


def share_of(axis: Axes, line: Line2D) -> float:
    """How far up a panel a line ends; at its top where it ends beyond."""
    ends = [float(one) for one in np.asarray(line.get_ydata(), dtype=np.float64) if math.isfinite(one)]
    if not ends:
        return 1.0
    _, y = axis.transData.transform((1.0, ends[-1]))
    _, share = axis.transAxes.inverted().transform((0.0, y))
    return float(share)


def place_name(axis: Axes, line: Line2D, where: float) -> None:
    """Beside a panel, led to by a line from the end of the curve."""
    ends = [float(one) for one in np.asarray(line.get_ydata(), dtype=np.float64) if math.isfinite(one)]
    last = float(np.asarray(line.get_xdata(), dtype=np.float64)[-1])
    axis.annotate(
        str(line.get_label()),
        (last, ends[-1]) if ends else (last, axis.get_ylim()[1]),
        (1.0 + LEAD / axis.bbox.width, where),
        textcoords=axis.transAxes,
        ha="left",
        va="center",
        fontsize=NAME,
        color=line.get_color(),
        arrowprops={
            "arrowstyle": "-",
            "color": line.get_color(),
            "linewidth": 0.5,
            "shrinkA": 1.0,
            "shrinkB": 0.0,
        },
        annotation_clip=False,
    )
