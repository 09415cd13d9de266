"""The picture of a part: the curves of its data sheet."""

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MultipleLocator, NullLocator

from hydroservo.core.formatting import DEGREES
from hydroservo.figures.panels import axis_unit
from hydroservo.figures.style import GREY, Plot, figure, style

if TYPE_CHECKING:
    from hydroservo.scenario.part_curves import PartPanel

HEIGHT = 2.5  # inch
PHASE_STEP = 45.0  # degrees
OWN = {"deg": (DEGREES, 1.0)}  # units that are read as they are
BANDWIDTH = {"dB": -3.0, "deg": -90.0}  # where a data sheet reads the frequency of a response


def plot_part(panels: "Sequence[PartPanel]") -> Plot:
    """Panels side by side, their axes in the units of data sheets."""
    with style():
        fig = figure(HEIGHT)
        for axis, panel in zip(np.atleast_1d(fig.subplots(1, len(panels))), panels, strict=True):
            draw_panel(axis, panel)
    return fig


def draw_panel(axis: Axes, panel: "PartPanel") -> None:
    """The curves of a panel."""
    x_unit, x_factor = unit_of(panel.x[1], chain.from_iterable(one.x for one in panel.curves))
    y_unit, y_factor = unit_of(panel.y[1], chain.from_iterable(one.y for one in panel.curves))
    for one in panel.curves:
        axis.plot(x_factor * one.x, y_factor * one.y, label=one.label)
    if panel.logarithmic:
        axis.set_xscale("log")
        axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axis.xaxis.set_minor_locator(NullLocator())
    if panel.y[1] in BANDWIDTH:
        axis.axhline(BANDWIDTH[panel.y[1]], color=GREY, linewidth=0.8, zorder=1)
    if panel.y[1] == "deg":
        axis.yaxis.set_major_locator(MultipleLocator(PHASE_STEP))
    if min(float(one.y.min()) for one in panel.curves) >= 0.0:
        axis.set_ylim(bottom=0.0)
    if any(one.label for one in panel.curves):
        axis.legend(loc="best")
    axis.set_xlabel(f"{panel.x[0]} [{x_unit}]")
    axis.set_ylabel(f"{panel.y[0]} [{y_unit}]")


def unit_of(unit: str, values: Iterable[float]) -> tuple[str, float]:
    """The unit of an axis, and the factor to it."""
    return OWN.get(unit) or axis_unit(unit, max(map(abs, values), default=0.0))
