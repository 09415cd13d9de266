"""The factorial of laws and observers: what each pair comes to, and what is owed to which factor."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm, to_hex
from matplotlib.patches import Rectangle

from hydroservo.core.formatting import NONE, number
from hydroservo.figures.studies.looks import SOFT, distinct, fix_layout, ink_on
from hydroservo.figures.style import PALETTE, Plot, figure, style

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
    """A table of laws by observers, coloured by their ratio, beside the shares of the factors.

    Args:
        pairs: those that were tried; others stay empty.
        parts: from top to bottom; none leaves the table alone.
        label: what the numbers of the table are.
    """
    laws, observers = distinct(pair.law for pair in pairs), distinct(pair.observer for pair in pairs)
    with style(maths=False):
        fig = figure(0.75 + ROW * max(len(laws), len(parts)))
        if parts:
            table, bars = fig.subplots(1, 2, width_ratios=[1.25, 1.0])
            draw_parts(bars, parts)
        else:
            table = fig.subplots()
        draw_table(table, pairs, laws, observers)
        table.set_xlabel(label)
        fix_layout(fig)
    return fig


def draw_table(
    axis: Axes, pairs: Sequence[Combination], laws: Sequence[str], observers: Sequence[str]
) -> None:
    norm = norm_of(pairs)
    for pair in pairs:
        x, y = observers.index(pair.observer), laws.index(pair.law)
        colour = UNKNOWN if math.isnan(pair.value) else to_hex(RATIOS(norm(min(pair.value, WIDEST))))
        axis.add_patch(Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, facecolor=colour, edgecolor="white"))
        ink = ink_on(colour)
        axis.text(
            x,
            y - 0.2 if beneath(pair) else y,
            written(pair),
            ha="center",
            va="center",
            color=ink,
        )
        axis.text(x, y + 0.02, beneath(pair), ha="center", va="top", color=ink, fontsize=6)
    axis.set(xlim=(-0.5, len(observers) - 0.5), ylim=(len(laws) - 0.5, -0.5))
    axis.set_xticks(range(len(observers)), observers)
    axis.set_yticks(range(len(laws)), laws)
    axis.xaxis.tick_top()
    axis.tick_params(length=0)
    axis.grid(visible=False)
    axis.spines[:].set_visible(False)


def written(pair: Combination) -> str:
    """A ratio as it stands in the table."""
    return NONE if math.isnan(pair.value) else "lost" if math.isinf(pair.value) else number(pair.value)


def beneath(pair: Combination) -> str:
    """The interval of a ratio, and its lost runs."""
    lost = f"{number(100.0 * pair.lost, 2)} % lost" if pair.lost > 0.0 else ""
    bounds = math.isfinite(pair.value) and pair.low < pair.high
    interval = f"[{number(pair.low)}, {number(pair.high)}]" if bounds else ""
    return "\n".join(part for part in (interval, lost) if part)


def norm_of(pairs: Sequence[Combination]) -> LogNorm:
    finite = [pair.value for pair in pairs if 0.0 < pair.value < math.inf]
    furthest = max((max(value, 1.0 / value) for value in finite), default=NARROWEST)
    reach = min(max(furthest, NARROWEST), WIDEST)
    return LogNorm(1.0 / reach, reach, clip=True)


def draw_parts(axis: Axes, parts: Sequence[FactorShare]) -> None:
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
    axis.spines["left"].set_color(SOFT)
    axis.set_xlabel("share of the variation\nof log error [%]")
