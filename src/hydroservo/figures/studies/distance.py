"""How far each law is from the least error that any command could leave."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.axes import Axes

from hydroservo.figures.studies.looks import INK, SOFT, family_colours, fix_layout, plain_log
from hydroservo.figures.style import Plot, figure, style
from hydroservo.formatting import NONE, number

LINE = 0.2  # inch
MARGIN = 1.35  # beyond the longest bar, so that its number has room
CAUSAL = "#e4e7ea"


class Distance(NamedTuple):
    """A law's error over the limit.

    Ends of the interval are quartiles of searches; all inf where the law is lost.
    """

    law: str
    family: str
    value: float  # [-]
    low: float
    high: float


def plot_distance(distances: Sequence[Distance], families: Sequence[str], causal: float = math.nan) -> Plot:
    """Bars from 1, the limit of a command that knows the future, to each law's multiple of it.

    Grey reaches to the limit of a command that knows only the past: no law can end inside it.

    Args:
        distances: from top to bottom.
        families: all of the study, in the order that gives them their colours.
        causal: the causal limit over the clairvoyant one; nan where it is not known.
    """
    colours = family_colours(families)
    finite = [one for line in distances for one in (line.value, line.high) if math.isfinite(one)]
    known = [*finite, *([] if math.isnan(causal) else [causal])]
    low, high = min([1.0, *known]), max([1.2, *known])
    with style(maths=False):
        fig = figure(0.75 + LINE * len(distances))
        axis = fig.subplots()
        plain_log(axis.xaxis, low if low == 1.0 else low / MARGIN, MARGIN * high, most=10)
        axis.axvline(1.0, color=INK, linewidth=0.8, zorder=4)
        if not math.isnan(causal):
            axis.axvspan(1.0, causal, color=CAUSAL, linewidth=0, zorder=0)
            axis.axvline(causal, color=SOFT, linewidth=0.8)
            axis.text(causal, -0.75, " causal limit", ha="left", va="bottom", fontsize=7.5, color=SOFT)
        for y, line in enumerate(distances):
            draw_bar(axis, y, line, colours[line.family])
        axis.set_ylim(len(distances) - 0.4, -0.7)
        axis.set_yticks(range(len(distances)), [line.law for line in distances])
        axis.tick_params(axis="y", length=0)
        axis.grid(visible=False, axis="y")
        axis.set_xlabel("error over that of the clairvoyant limit")
        fix_layout(fig)
    return fig


def draw_bar(axis: Axes, y: int, line: Distance, colour: str) -> None:
    if not math.isfinite(line.value):
        text = "lost" if math.isinf(line.value) else NONE
        axis.text(1.0, y, f" {text}", va="center", fontsize=7.5, color=SOFT)
        return
    axis.barh(y, line.value - 1.0, left=1.0, height=0.6, color=colour, zorder=2)
    axis.plot([line.low, line.high], [y, y], color=INK, linewidth=1.0, zorder=3)
    axis.annotate(
        number(line.value),
        (max(line.value, line.high), y),
        (4, 0),
        textcoords="offset points",
        va="center",
        fontsize=7.5,
    )
