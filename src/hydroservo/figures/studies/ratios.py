"""Ratios with their intervals: forest plots, factorials of laws and observers, distances from the limit."""

import math
from collections.abc import Sequence
from textwrap import fill
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm, to_hex
from matplotlib.patches import Rectangle

from hydroservo.core.formatting import NONE, number
from hydroservo.figures.studies import looks
from hydroservo.figures.style import PALETTE, Plot, figure, style

LESS, MORE, TIE = PALETTE[0], PALETTE[1], "#8a939c"
LINE = 0.19  # inch
WIDEST, NARROWEST = 20.0, 1.25  # how far a ratio's axis reaches from 1, at most and at least
MARGIN = 1.06  # beyond the last interval
BAND = "#eef0f2"
NAME = 24  # characters in a line of a name
NUMBERS, NOTES = 10.0, 118.0  # points from the plot to the columns beside it
TICKS = 6
BAR = 0.2  # inch
BEYOND_BARS = 1.35  # beyond the longest bar, so that its number has room
CAUSAL = "#e4e7ea"


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
    """
    names = [fill(one.label, NAME) for one in effects]
    tallest = max((name.count("\n") + 1 for name in names), default=1)
    with style(maths=False):
        fig = figure(0.75 + LINE * (0.8 * tallest + 0.2) * (len(effects) + 1))
        axis = fig.subplots()
        reach = axis_reach(effects)
        looks.plain_log(axis.xaxis, 1.0 / reach, reach, TICKS)
        axis.axvspan(1.0 / tie, tie, color=BAND, linewidth=0)
        axis.axvline(1.0, color=looks.INK, linewidth=0.8)
        write_beside(axis, -1.0, "ratio [interval]", notes, looks.SOFT)
        for line, one in enumerate(effects):
            draw_effect(axis, line, one, reach)
            write_beside(axis, line, ratio_with_interval(one), one.note, looks.INK)
        axis.set_yticks(range(len(effects)), names)
        axis.set_ylim(len(effects) - 0.4, -1.4)
        axis.tick_params(axis="y", length=0)
        axis.grid(visible=False, axis="y")
        axis.spines["left"].set_visible(False)
        axis.set_xlabel(label)
        looks.fix_layout(fig)
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


def axis_reach(effects: Sequence[RatioLine]) -> float:
    """How far from 1 the axis goes: to the furthest finite end, but no further than it can be read."""
    ends = [end for one in effects for end in (one.low, one.value, one.high) if 0.0 < end < math.inf]
    furthest = max((max(end, 1.0 / end) for end in ends), default=1.0)
    return min(max(MARGIN * furthest, NARROWEST), WIDEST)


def ratio_with_interval(effect: RatioLine) -> str:
    """A ratio and its interval as they are read."""
    if math.isnan(effect.value):
        return NONE
    return f"{number(effect.value)} [{number(effect.low)}, {number(effect.high)}]"


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
    """
    colours = looks.family_colours(families)
    finite = [one for line in distances for one in (line.value, line.high) if math.isfinite(one)]
    known = [*finite, *([] if math.isnan(causal) else [causal])]
    low, high = min([1.0, *known]), max([1.2, *known])
    with style(maths=False):
        fig = figure(0.75 + BAR * len(distances))
        axis = fig.subplots()
        looks.plain_log(axis.xaxis, low if low == 1.0 else low / BEYOND_BARS, BEYOND_BARS * high, most=10)
        axis.axvline(1.0, color=looks.INK, linewidth=0.8, zorder=4)
        if not math.isnan(causal):
            axis.axvspan(1.0, causal, color=CAUSAL, linewidth=0, zorder=0)
            axis.axvline(causal, color=looks.SOFT, linewidth=0.8)
            axis.text(causal, -0.75, " causal limit", ha="left", va="bottom", fontsize=7.5, color=looks.SOFT)
        for y, line in enumerate(distances):
            draw_bar(axis, y, line, colours[line.family])
        axis.set_ylim(len(distances) - 0.4, -0.7)
        axis.set_yticks(range(len(distances)), [line.law for line in distances])
        axis.tick_params(axis="y", length=0)
        axis.grid(visible=False, axis="y")
        axis.set_xlabel("error over that of the clairvoyant limit")
        looks.fix_layout(fig)
    return fig


def draw_bar(axis: Axes, y: int, line: Distance, colour: str) -> None:
    if not math.isfinite(line.value):
        text = "lost" if math.isinf(line.value) else NONE
        axis.text(1.0, y, f" {text}", va="center", fontsize=7.5, color=looks.SOFT)
        return
    axis.barh(y, line.value - 1.0, left=1.0, height=0.6, color=colour, zorder=2)
    axis.plot([line.low, line.high], [y, y], color=looks.INK, linewidth=1.0, zorder=3)
    axis.annotate(
        number(line.value),
        (max(line.value, line.high), y),
        (4, 0),
        textcoords="offset points",
        va="center",
        fontsize=7.5,
    )


# Source: Brewer's PuOr about a neutral 1, told apart with any common colour vision.
RATIOS = LinearSegmentedColormap.from_list("ratios", ["#08519c", "#9ecae1", "#f7f7f7", "#fdc078", "#b35806"])
NARROWEST = 1.5  # how far the colours reach from 1, at least
WIDEST = 4.0  # and at most
ROW = 0.44  # inch
UNKNOWN = "#ffffff"


class Combination(NamedTuple):
    """A law with an observer: the ratio of its error to the reference's."""

    law: str
    observer: str
    value: float  # [-]; inf where all runs are lost, nan where it is not known
    low: float
    high: float
    lost: float  # share of lost runs


class FactorShare(NamedTuple):
    """The share of the variation of log error that is owed to a factor."""

    factor: str
    value: float
    low: float
    high: float


def plot_factorial(pairs: Sequence[Combination], parts: Sequence[FactorShare], label: str) -> Plot:
    """A table of laws by observers, coloured by their ratio, beside the shares of the factors."""
    laws, observers = (
        looks.without_repetitions(pair.law for pair in pairs),
        looks.without_repetitions(pair.observer for pair in pairs),
    )
    with style(maths=False):
        fig = figure(0.75 + ROW * max(len(laws), len(parts)))
        if parts:
            table, bars = fig.subplots(1, 2, width_ratios=[1.25, 1.0])
            draw_factor_shares(bars, parts)
        else:
            table = fig.subplots()
        draw_table(table, pairs, laws, observers)
        table.set_xlabel(label)
        looks.fix_layout(fig)
    return fig


def draw_table(
    axis: Axes, pairs: Sequence[Combination], laws: Sequence[str], observers: Sequence[str]
) -> None:
    norm = ratio_norm(pairs)
    for pair in pairs:
        x, y = observers.index(pair.observer), laws.index(pair.law)
        colour = UNKNOWN if math.isnan(pair.value) else to_hex(RATIOS(norm(min(pair.value, WIDEST))))
        axis.add_patch(Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, facecolor=colour, edgecolor="white"))
        ink = looks.ink_on(colour)
        axis.text(
            x, y - 0.2 if beneath_text(pair) else y, ratio_text(pair), ha="center", va="center", color=ink
        )
        axis.text(x, y + 0.02, beneath_text(pair), ha="center", va="top", color=ink, fontsize=6)
    axis.set(xlim=(-0.5, len(observers) - 0.5), ylim=(len(laws) - 0.5, -0.5))
    axis.set_xticks(range(len(observers)), observers)
    axis.set_yticks(range(len(laws)), laws)
    axis.xaxis.tick_top()
    axis.tick_params(length=0)
    axis.grid(visible=False)
    axis.spines[:].set_visible(False)


def ratio_text(pair: Combination) -> str:
    """A ratio as it stands in the table."""
    return NONE if math.isnan(pair.value) else "lost" if math.isinf(pair.value) else number(pair.value)


def beneath_text(pair: Combination) -> str:
    """The interval of a ratio, and its lost runs."""
    lost = f"{number(100.0 * pair.lost, 2)} % lost" if pair.lost > 0.0 else ""
    bounds = math.isfinite(pair.value) and pair.low < pair.high
    interval = f"[{number(pair.low)}, {number(pair.high)}]" if bounds else ""
    return "\n".join(part for part in (interval, lost) if part)


def ratio_norm(pairs: Sequence[Combination]) -> LogNorm:
    finite = [pair.value for pair in pairs if 0.0 < pair.value < math.inf]
    furthest = max((max(value, 1.0 / value) for value in finite), default=NARROWEST)
    reach = min(max(furthest, NARROWEST), WIDEST)
    return LogNorm(1.0 / reach, reach, clip=True)


def draw_factor_shares(axis: Axes, parts: Sequence[FactorShare]) -> None:
    """Bars of shares, with intervals."""
    for y, part in enumerate(parts):
        axis.barh(y, 100.0 * part.value, height=0.55, color=PALETTE[0])
        axis.plot([100.0 * part.low, 100.0 * part.high], [y, y], color="black", linewidth=1.0)
        axis.text(
            100.0 * max(part.high, part.value) + 1.5,
            y,
            f"{number(100.0 * part.value, 2)} %",
            va="center",
            fontsize=7.5,
        )
    furthest = 100.0 * max(max(part.high, part.value) for part in parts)
    axis.set(ylim=(len(parts) - 0.4, -0.6), xlim=(0.0, 1.25 * furthest))
    axis.set_yticks(range(len(parts)), [part.factor for part in parts])
    axis.tick_params(axis="y", length=0)
    axis.grid(visible=False, axis="y")
    axis.spines["left"].set_color(looks.SOFT)
    axis.set_xlabel("share of the variation\nof log error [%]")
