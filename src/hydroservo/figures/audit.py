"""The picture of an audit: by which factor each assumption of a law holds."""

import math
from collections.abc import Sequence
from textwrap import fill

from hydroservo.core.assumptions import Assumption
from hydroservo.core.formatting import number
from hydroservo.figures.style import GREY, PALETTE, Plot, figure, style

ROW = 0.42  # inch, of an assumption
LEAST, MOST = 1e-3, 1e3  # factors beyond which a margin is at the edge
LABEL = 44  # characters in a line
DOT = 6.0  # points


def plot_margins(assumptions: Sequence[Assumption]) -> Plot:
    """The margin of each assumption on a logarithmic axis; those below 1 fail, and are in another colour.

    A margin beyond a factor of 1000, or without end, stands at the edge of the axis with a triangle.
    """
    shown = [min(max(one.margin, LEAST), MOST) for one in assumptions]
    low, high = min([0.5, *shown]) / 1.5, max([2.0, *shown]) * 1.5
    with style():
        fig = figure(0.8 + ROW * len(assumptions))
        axis = fig.subplots()
        axis.axvline(1.0, color=GREY, linewidth=0.8)
        for row, (one, margin) in enumerate(zip(assumptions, shown, strict=True)):
            marker = "o" if margin == one.margin else ">" if margin == MOST else "<"
            colour = PALETTE[0] if one.holds else PALETTE[1]
            axis.plot([1.0, margin], [row, row], color=colour, linewidth=1.2, zorder=1)
            axis.plot([margin], [row], marker=marker, color=colour, markersize=DOT, clip_on=False)
        labels = [fill(one.meaning.replace("$", r"\$"), LABEL) for one in assumptions]
        axis.set_yticks(range(len(assumptions)), labels)
        axis.set_ylim(len(assumptions) - 0.5, -0.5)
        axis.set_xscale("log")
        axis.set_xlim(low, high)
        axis.grid(axis="y", visible=False)
        axis.set_xlabel("margin")
        axis.xaxis.set_major_formatter(lambda value, _: number(value, 1) if math.isfinite(value) else "")
    return fig
