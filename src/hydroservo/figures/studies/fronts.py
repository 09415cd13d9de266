"""What error costs in command activity: the fronts of laws, a panel a cell."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from hydroservo.figures.studies.looks import FAMILIES, INK, SOFT, fix_layout, plain_log
from hydroservo.figures.style import Plot, figure, style
from hydroservo.formatting import quantity

ACROSS = 4  # panels in a row
HEIGHT, ALONE = 1.75, 2.6  # inch, of a panel: of several rows, and of one
KEY = 0.9  # inch, of what is below
WORST = 1.35  # times the reference's error, up to which fronts are shown
MARGIN = 1.15  # about the levels and the least error
PALE = "#c9d1d8"
Ratio = tuple[float, float, float]  # value, low, high


class FrontLine(NamedTuple):
    """The front of a law."""

    law: str
    activity: Sequence[float]  # over that of the reference, rising
    error: Sequence[Ratio]  # over that of the reference at its own activity, falling, with its interval
    taken: Sequence[tuple[float, float]]  # activity and error of the points that are compared


class FrontPanel(NamedTuple):
    """The fronts of a cell."""

    title: str
    error: float  # of the reference at its own activity [unit of the metric]
    activity: float  # its own [%/s]
    lines: Sequence[FrontLine]


def plot_fronts(
    panels: Sequence[FrontPanel], named: Sequence[str], reference: str, levels: Sequence[float], unit: str
) -> Plot:
    """Error over command activity, both over the reference's; bands are intervals of named laws.

    Dots are the points at which laws are compared.

    Args:
        panels: of each cell.
        named: the laws that have colours, in order; others are pale.
        reference: the law of which both axes are multiples.
        levels: the activities at which laws are compared.
        unit: of the error.
    """
    colours = dict(zip(named, cycle(FAMILIES), strict=False)) | {reference: INK}
    across = min(ACROSS, len(panels))
    down = -(-len(panels) // across)
    errors = [ratio[0] for panel in panels for line in panel.lines for ratio in line.error]
    least = min([1.0, *(one for one in errors if one > 0.0)])
    pale = any(line.law not in colours for panel in panels for line in panel.lines)
    with style(maths=False):
        fig = figure((HEIGHT if down > 1 else ALONE) * down + KEY)
        axes = fig.subplots(down, across, sharex=True, sharey=True, squeeze=False)
        for axis, panel in zip(axes.flat, panels, strict=False):
            plain_log(axis.xaxis, levels[0] / MARGIN, levels[-1] * MARGIN)
            plain_log(axis.yaxis, least / MARGIN**0.3, WORST)
            axis.axhline(1.0, color=SOFT, linewidth=0.6, zorder=1)
            draw_lines(axis, panel.lines, colours)
            about = f"{quantity(panel.error, unit)} at {panel.activity:.2g} %/s"
            axis.set_title(f"{panel.title}\n{about}", fontsize=7.5, loc="left", linespacing=1.3)
        for axis in axes.flat[len(panels) :]:
            axis.set_axis_off()
        for axis in axes.flat[max(len(panels) - across, 0) : len(panels)]:
            axis.tick_params(labelbottom=True)
            axis.set_xlabel(f"activity over {reference}'s")
        for axis in axes[:, 0]:
            axis.set_ylabel(f"error over {reference}'s")
        fig.legend(handles=key(colours, pale), loc="outside lower center", ncols=4)
        fix_layout(fig)
    return fig


def draw_lines(axis: Axes, lines: Sequence[FrontLine], colours: Mapping[str, str]) -> None:
    """The fronts of a cell, the pale ones below."""
    for line in sorted(lines, key=lambda one: one.law in colours):
        colour = colours.get(line.law, PALE)
        value, low, high = zip(*line.error, strict=True)
        strong = line.law in colours
        axis.plot(line.activity, value, color=colour, linewidth=1.2 if strong else 0.6, zorder=2 + strong)
        if strong:
            for activity, error in line.taken:
                axis.plot(activity, error, ".", color=colour, markersize=4, zorder=4)
            axis.fill_between(line.activity, low, high, color=colour, alpha=0.15, linewidth=0, zorder=2)


def key(colours: Mapping[str, str], pale: bool) -> list[Line2D]:
    """What colours mean."""
    own = [Line2D([], [], color=colour, linewidth=1.2, label=law) for law, colour in colours.items()]
    return [*own, Line2D([], [], color=PALE, linewidth=0.8, label="other laws")] if pale else own
