"""Colours of families and marks of observers, the same in all pictures of a study, and names of points."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle, pairwise, product
from math import cos, hypot, pi, sin
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

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
Numbers = NDArray[np.float64]

ROUND = 16  # directions that are tried
DISTANCES = (7.0, 13.0, 22.0, 34.0, 48.0, 66.0)  # points
LEADER = 10.0  # points, from which on a line leads to the name
SIZE = 7.5  # points, of a name
HALF = 3.0  # pixels, of a point's size
DOTTED = 5.0  # pixels
EDGE = 6.0  # pixels inside a panel that stay free
AIR = 1.5  # pixels about a name
OUTSIDE = 1e6  # pixels: worse than any overlap


def without_repetitions(names: Iterable[str]) -> list[str]:
    """The names without repetitions, in order of their first appearance."""
    return list(dict.fromkeys(names))


def family_colours(families: Iterable[str]) -> dict[str, str]:
    """A colour for each family of laws, in order of appearance; from the eleventh on they come again."""
    return dict(zip(without_repetitions(families), cycle(FAMILIES), strict=False))


def observer_marks(observers: Iterable[str]) -> Mapping[str, str]:
    """A mark for each observer but that without a name; from the ninth on they come again."""
    return dict(zip((name for name in without_repetitions(observers) if name), cycle(MARKS), strict=False))


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


class NamedPoint(NamedTuple):
    """A point and its name."""

    name: str
    x: float
    y: float
    colour: str


def name_points(
    fig: Figure,
    axis: Axes,
    named: Sequence[NamedPoint],
    others: Sequence[tuple[float, float]],
    line: Sequence[tuple[float, float]] = (),
) -> None:
    """Write names beside points where they cover neither each other nor a point nor a line.

    Each takes the nearest place that is free, in the order given; where none is, that of the least overlap.
    Call it last, for it takes the layout as it is.
    """
    fix_layout(fig)
    points = axis.transData.transform([(one.x, one.y) for one in named] + [*others])
    dots = np.concatenate([points, dotted(axis.transData.transform(line or [(1.0, 1.0)]))])
    taken = np.hstack([dots - HALF, dots + HALF])
    offsets = np.array(
        [(far * cos(angle), far * sin(angle)) for far, angle in product(DISTANCES, name_directions())]
    )
    for one, point in zip(named, points[: len(named)], strict=True):
        found = name_boxes(point, offsets * fig.dpi / 72.0, name_size(fig, one.name))
        best = int(np.argmin(overlap_costs(found, taken, np.asarray(axis.bbox.padded(-EDGE).extents))))
        write_name(axis, one, (float(offsets[best, 0]), float(offsets[best, 1])))
        taken = np.vstack([taken, found[best]])


def dotted(corners: Numbers) -> Numbers:
    """Points on a line, so near to each other that no name fits between them; shape (points, 2)."""
    found = [corners[:0]]
    for start, stop in pairwise(corners):
        count = int(hypot(*(stop - start)) / DOTTED) + 1
        found.append(start + (stop - start) * np.linspace(0.0, 1.0, count + 1)[:, np.newaxis])
    return np.concatenate(found)


def name_directions() -> list[float]:
    """Directions, those beside a point before those above and below it."""
    return sorted(
        (2.0 * pi * step / ROUND + pi / ROUND for step in range(ROUND)), key=lambda one: abs(sin(one))
    )


def name_size(fig: Figure, name: str) -> tuple[float, float]:
    """Width and height of a name, in pixels."""
    text = fig.text(0.0, 0.0, name, fontsize=SIZE)
    found = text.get_window_extent()
    text.remove()
    return found.width, found.height


def name_boxes(point: Numbers, offsets: Numbers, extent: tuple[float, float]) -> Numbers:
    """Where a name would lie, with air about it: beyond each offset, on the side away from the point.

    Returns:
        Left, bottom, right and top, shape (offsets, 4).
    """
    width, height = extent
    left = point[0] + offsets[:, 0] - np.where(offsets[:, 0] > 0.0, 0.0, width)
    bottom = point[1] + offsets[:, 1] - 0.5 * height
    return np.stack([left - AIR, bottom - AIR, left + width + AIR, bottom + height + AIR], axis=1)


def overlap_costs(found: Numbers, taken: Numbers, panel: Numbers) -> Numbers:
    """The area, in pixels, that each box would share with others, and more where it leaves the panel."""
    low = np.maximum(found[:, np.newaxis, :2], taken[np.newaxis, :, :2])
    high = np.minimum(found[:, np.newaxis, 2:], taken[np.newaxis, :, 2:])
    shared: Numbers = np.clip(high - low, 0.0, None).prod(axis=2).sum(axis=1)
    kept = (found[:, :2] >= panel[:2]).all(axis=1) & (found[:, 2:] <= panel[2:]).all(axis=1)
    return shared + np.where(kept, 0.0, OUTSIDE)


def write_name(axis: Axes, named: NamedPoint, offset: tuple[float, float]) -> None:
    """A name at an offset in points, with a line to its point where that is far."""
    line = {"arrowstyle": "-", "color": SOFT, "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 2.0}
    axis.annotate(
        named.name,
        (named.x, named.y),
        offset,
        textcoords="offset points",
        ha="left" if offset[0] > 0.0 else "right",
        va="center",
        fontsize=SIZE,
        color=named.colour,
        arrowprops=line if hypot(*offset) > LEADER else None,
        zorder=5,
    )
