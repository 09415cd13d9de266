"""Names beside points, none over another."""

from collections.abc import Sequence
from itertools import pairwise, product
from math import cos, hypot, pi, sin
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hydroservo.figures.studies.looks import SOFT, fix_layout

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


class Named(NamedTuple):
    """A point and its name."""

    name: str
    x: float
    y: float
    colour: str


def name_points(
    fig: Figure,
    axis: Axes,
    named: Sequence[Named],
    others: Sequence[tuple[float, float]],
    line: Sequence[tuple[float, float]] = (),
) -> None:
    """Write names beside points where they cover neither each other nor a point nor a line.

    Each takes the nearest place that is free, in the order given; where none is, that of the least overlap.
    Call it last, for it takes the layout as it is.

    Args:
        fig: the figure.
        axis: the axes of the points.
        named: the points that have a name.
        others: x and y of the points that have none.
        line: x and y of its corners.
    """
    fix_layout(fig)
    points = axis.transData.transform([(one.x, one.y) for one in named] + [*others])
    dots = np.concatenate([points, dotted(axis.transData.transform(line or [(1.0, 1.0)]))])
    taken = np.hstack([dots - HALF, dots + HALF])
    offsets = np.array([(far * cos(angle), far * sin(angle)) for far, angle in product(DISTANCES, angles())])
    for one, point in zip(named, points[: len(named)], strict=True):
        found = boxes(point, offsets * fig.dpi / 72.0, size(fig, one.name))
        best = int(np.argmin(costs(found, taken, np.asarray(axis.bbox.padded(-EDGE).extents))))
        write(axis, one, (float(offsets[best, 0]), float(offsets[best, 1])))
        taken = np.vstack([taken, found[best]])


def dotted(corners: Numbers) -> Numbers:
    """Points on a line, so near to each other that no name fits between them; shape (points, 2)."""
    found = [corners[:0]]
    for start, stop in pairwise(corners):
        count = int(hypot(*(stop - start)) / DOTTED) + 1
        found.append(start + (stop - start) * np.linspace(0.0, 1.0, count + 1)[:, np.newaxis])
    return np.concatenate(found)


def angles() -> list[float]:
    """Directions, those beside a point before those above and below it."""
    return sorted(
        (2.0 * pi * step / ROUND + pi / ROUND for step in range(ROUND)), key=lambda one: abs(sin(one))
    )


def size(fig: Figure, name: str) -> tuple[float, float]:
    """Width and height of a name, in pixels."""
    text = fig.text(0.0, 0.0, name, fontsize=SIZE)
    found = text.get_window_extent()
    text.remove()
    return found.width, found.height


def boxes(point: Numbers, offsets: Numbers, extent: tuple[float, float]) -> Numbers:
    """Where a name would lie, with air about it: beyond each offset, on the side away from the point.

    Returns:
        Left, bottom, right and top, shape (offsets, 4).
    """
    width, height = extent
    left = point[0] + offsets[:, 0] - np.where(offsets[:, 0] > 0.0, 0.0, width)
    bottom = point[1] + offsets[:, 1] - 0.5 * height
    return np.stack([left - AIR, bottom - AIR, left + width + AIR, bottom + height + AIR], axis=1)


def costs(found: Numbers, taken: Numbers, panel: Numbers) -> Numbers:
    """The area, in pixels, that each box would share with others, and more where it leaves the panel."""
    low = np.maximum(found[:, np.newaxis, :2], taken[np.newaxis, :, :2])
    high = np.minimum(found[:, np.newaxis, 2:], taken[np.newaxis, :, 2:])
    shared: Numbers = np.clip(high - low, 0.0, None).prod(axis=2).sum(axis=1)
    kept = (found[:, :2] >= panel[:2]).all(axis=1) & (found[:, 2:] <= panel[2:]).all(axis=1)
    return shared + np.where(kept, 0.0, OUTSIDE)


def write(axis: Axes, named: Named, offset: tuple[float, float]) -> None:
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
