"""Colours of families and marks of observers, the same in all pictures of a study."""

import math
from collections.abc import Iterable, Mapping
from itertools import cycle

import numpy as np
from matplotlib.axis import Axis
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from matplotlib.transforms import Bbox

from hydroservo.figures.style import PALETTE

# Source: Okabe and Ito, 2008, and for more than six Paul Tol's muted scheme, 2021.
FAMILIES = (*PALETTE, "#332288", "#882255", "#999933", "#44AA99")
MARKS = ("o", "^", "s", "D", "v", "P", "*", "X")
INK = "#1c2733"
SOFT = "#5b6875"
TIE = "#c3c9cf"
DARK = 0.55  # the luminance below which writing is white
LUMINANCE = (0.2126, 0.7152, 0.0722)  # Source: ITU-R BT.709

DIGITS = 6  # of positions, as shares of the figure
STEPS = (  # of ticks in a decade, coarser and coarser
    (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 9.5),
    (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0),
    (1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    (1.0, 2.0, 5.0),
    (1.0, 3.0),
    (1.0,),
)
MOST = 7  # ticks


def distinct(names: Iterable[str]) -> list[str]:
    """The names without repetitions, in order of their first appearance."""
    return list(dict.fromkeys(names))


def family_colours(families: Iterable[str]) -> dict[str, str]:
    """A colour for each family of laws, in order of appearance; from the eleventh on they come again."""
    return dict(zip(distinct(families), cycle(FAMILIES), strict=False))


def observer_marks(observers: Iterable[str]) -> Mapping[str, str]:
    """A mark for each observer but that without a name; from the ninth on they come again."""
    return dict(zip((name for name in distinct(observers) if name), cycle(MARKS), strict=False))


def paler(colour: str, share: float) -> str:
    """A colour of which a share between 0 (white) and 1 is left."""
    red, green, blue = (1.0 - share * (1.0 - part) for part in to_rgb(colour))
    return to_hex((red, green, blue))


def ink_on(colour: str) -> str:
    """The colour of writing that is readable on another."""
    light = math.fsum(weight * part for weight, part in zip(LUMINANCE, to_rgb(colour), strict=True))
    return "#ffffff" if light < DARK else INK


def fix_layout(fig: Figure) -> None:
    """Lay a figure out, and leave it so whatever is drawn on it later.

    The solver of layouts takes its unknowns in an order that changes from one time to the next, and so leaves
    other last digits; these are rounded away, for the same picture to give the same bytes.

    Args:
        fig: the figure, all that needs room on it drawn.
    """
    fig.draw_without_rendering()
    fig.set_layout_engine("none")
    for part in fig.subfigs:
        part.bbox_relative.set_points(np.round(part.bbox_relative.get_points(), DIGITS))
    for axis in fig.axes:
        axis.set_position(Bbox(np.round(axis.get_position(original=True).get_points(), DIGITS)))


def plain_log(axis: Axis, low: float, high: float, most: int = MOST) -> None:
    """Make an axis logarithmic, from ``low`` to ``high`` above 0, with few round ticks, written plainly."""
    axis.axes.set(**{f"{axis.axis_name}scale": "log", f"{axis.axis_name}lim": (low, high)})  # type: ignore[attr-defined]
    axis.set_major_locator(FixedLocator(round_ticks(low, high, most)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda tick, _: f"{tick:g}"))


def round_ticks(low: float, high: float, most: int) -> list[float]:
    """The finest of round steps that has no more ticks than so many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    found: list[float] = []
    for steps in STEPS:
        found = [float(f"{step}e{decade}") for decade in decades for step in steps]
        found = [tick for tick in found if low <= tick <= high]
        if len(found) <= most:
            break
    return found
