"""Forest plots: ratios with their intervals, a line each."""

import math
from collections.abc import Sequence
from textwrap import fill
from typing import NamedTuple

from matplotlib.axes import Axes

from hydroservo.figures.studies.looks import INK, SOFT, fix_layout, plain_log
from hydroservo.figures.style import PALETTE, Plot, figure, style
from hydroservo.formatting import NONE, number

LESS, MORE, TIE = PALETTE[0], PALETTE[1], "#8a939c"
LINE = 0.19  # inch
WIDEST, NARROWEST = 20.0, 1.25  # how far a ratio's axis reaches from 1, at most and at least
MARGIN = 1.06  # beyond the last interval
BAND = "#eef0f2"
NAME = 24  # characters in a line of a name
NUMBERS, NOTES = 10.0, 118.0  # points from the plot to the columns beside it
TICKS = 6


class RatioLine(NamedTuple):
    """A ratio with its interval.

    ``value`` is nan where there is no estimate; ends of the interval may be 0 and inf.
    """

    label: str
    value: float
    low: float
    high: float
    sure: bool  # it is no tie
    note: str = ""  # printed at the end of the line


def plot_forest(effects: Sequence[RatioLine], label: str, tie: float = 1.0, notes: str = "") -> Plot:
    """Ratios to 1 with their intervals on a logarithmic axis, with the numbers beside them.

    Blue is surely below 1, vermilion surely above, grey a tie. An arrow leaves where an interval goes on.

    Args:
        effects: from top to bottom.
        label: of the axis.
        tie: ratios nearer to 1 than this one tie; shown as a band.
        notes: the heading of the notes.
    """
    names = [fill(one.label, NAME) for one in effects]
    tallest = max((name.count("\n") + 1 for name in names), default=1)
    with style(maths=False):
        fig = figure(0.75 + LINE * (0.8 * tallest + 0.2) * (len(effects) + 1))
        axis = fig.subplots()
        reach = reach_of(effects)
        plain_log(axis.xaxis, 1.0 / reach, reach, TICKS)
        axis.axvspan(1.0 / tie, tie, color=BAND, linewidth=0)
        axis.axvline(1.0, color=INK, linewidth=0.8)
        write_beside(axis, -1.0, "ratio [interval]", notes, SOFT)
        for line, one in enumerate(effects):
            draw_effect(axis, line, one, reach)
            write_beside(axis, line, in_brackets(one), one.note, INK)
        axis.set_yticks(range(len(effects)), names)
        axis.set_ylim(len(effects) - 0.4, -1.4)
        axis.tick_params(axis="y", length=0)
        axis.grid(visible=False, axis="y")
        axis.spines["left"].set_visible(False)
        axis.set_xlabel(label)
        fix_layout(fig)
    return fig


def write_beside(axis: Axes, y: float, numbers: str, note: str, colour: str) -> None:
    """Two columns at the right of the plot."""
    for text, far in ((numbers, NUMBERS), (note, NOTES)):
        axis.annotate(
            text,
            (1.0, y),
            (far, 0.0),
            xycoords=axis.get_yaxis_transform(),
            textcoords="offset points",
            va="center",
            fontsize=8,
            color=colour,
            annotation_clip=False,
        )


def draw_effect(axis: Axes, y: float, effect: RatioLine, reach: float) -> None:
    if math.isnan(effect.value):
        return
    colour = TIE if not effect.sure else LESS if effect.value < 1.0 else MORE
    low, high = max(effect.low, 1.0 / reach), min(effect.high, reach)
    if low < high:
        axis.plot([low, high], [y, y], color=colour, linewidth=1.4, solid_capstyle="butt")
    for end, mark, beyond in ((low, "<", effect.low < low), (high, ">", effect.high > high)):
        if beyond:
            axis.plot(end, y, mark, color=colour, markersize=4, clip_on=False)
    if 1.0 / reach <= effect.value <= reach:
        axis.plot(
            effect.value, y, "o", color=colour, markersize=4.5, markeredgecolor="white", markeredgewidth=0.5
        )


def reach_of(effects: Sequence[RatioLine]) -> float:
    """How far from 1 the axis goes: to the furthest finite end, but no further than it can be read."""
    ends = [end for one in effects for end in (one.low, one.value, one.high) if 0.0 < end < math.inf]
    furthest = max((max(end, 1.0 / end) for end in ends), default=1.0)
    return min(max(MARGIN * furthest, NARROWEST), WIDEST)


def in_brackets(effect: RatioLine) -> str:
    """A ratio and its interval as they are read."""
    if math.isnan(effect.value):
        return NONE
    return f"{number(effect.value)} [{number(effect.low)}, {number(effect.high)}]"
