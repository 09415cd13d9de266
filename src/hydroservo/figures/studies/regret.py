"""Regret: how much worse than the best of each cell a law is, a small map for each law."""

import math
from collections.abc import Mapping
from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from hydroservo.figures.studies.grid import Grid, Place
from hydroservo.figures.studies.layout import fix_layout
from hydroservo.figures.studies.looks import SOFT
from hydroservo.figures.style import WIDTH, figure, style

__all__ = ["EDGES", "plot_regret"]

EDGES = (1.0, 1.1, 1.5, 2.0)  # of classes; the best itself is one of its own
# Source: Brewer's Blues and PuOr, told apart with any common colour vision.
FILLS = ("#08519c", "#6baed6", "#fee0b6", "#f1a340", "#b35806")
NAMES = ("best", "up to 1.1", "up to 1.5", "up to 2", "above 2")
HATCH = "xxxxx"
GAP = 0.5  # cells, between panels of a map
CELL = 0.26  # inch, at most
SMALLEST = 0.07  # inch, a cell that can be seen
SHORTEST = 1.3  # inch, a map's width, so that its title has room
TITLE = 0.42  # inch
NAME = 22  # characters in a line of a title


def plot_regret(grid: Grid, ratios: Mapping[str, Mapping[str, float]], near: float = 1.1) -> Figure:
    """A small map for each law: its error over that of the best law of the cell.

    The cells lie as in the map of winners: panels of that are blocks of these. Above each: the law, and in
    how many of the cells that any law masters it is near the best.

    Args:
        grid: the study's cells and axes.
        ratios: law -> cell -> ratio [-], 1 or more; inf where it is lost, nan where no law stays stable.
        near: a ratio up to which a law is near the best.
    """
    across, up = size(grid)
    columns = min(len(ratios), int((WIDTH - 0.5) / max(SMALLEST * across, SHORTEST)) or 1)
    rows = math.ceil(len(ratios) / columns)
    cell = min(CELL, (WIDTH - 0.6) / columns / across)
    with style(maths=False):
        fig = figure(0.75 + rows * (up * cell + TITLE))
        panels = fig.subplots(rows, columns, squeeze=False)
        for index, (axis, (law, found)) in enumerate(zip(panels.flat, ratios.items(), strict=False)):
            draw_law(axis, grid, found)
            label(axis, grid, law, counted(found, near), first=index == columns * (rows - 1))
        for axis in panels.flat[len(ratios) :]:
            axis.set_axis_off()
        fig.legend(handles=key(), loc="outside lower center", ncols=3)
        fix_layout(fig)
    return fig


def size(grid: Grid) -> tuple[float, float]:
    """Of a law's map, in cells."""
    across, up = grid.inside
    columns, rows = len(grid.columns), len(grid.rows)
    return columns * len(across) + GAP * (columns - 1), rows * len(up) + GAP * (rows - 1)


def corner(grid: Grid, place: Place) -> tuple[float, float]:
    """The lower left corner of a cell; rows of panels go downwards."""
    across, up = grid.inside
    return (
        place.column * (len(across) + GAP) + place.x,
        (len(grid.rows) - 1 - place.row) * (len(up) + GAP) + place.y,
    )


def draw_law(axis: Axes, grid: Grid, ratios: Mapping[str, float]) -> None:
    for cell, place in grid.places().items():
        if cell not in ratios:
            continue
        ratio = ratios[cell]
        found = Rectangle(corner(grid, place), 1.0, 1.0, edgecolor="white", linewidth=0.6)
        if math.isnan(ratio):
            found.set(facecolor="#e4e7ea")
        elif math.isinf(ratio):
            found.set(facecolor="white", edgecolor=SOFT, hatch=HATCH, linewidth=0.3)
        else:
            found.set(facecolor=FILLS[sum(ratio > edge for edge in EDGES)])
        axis.add_patch(found)
    width, height = size(grid)
    axis.set(xlim=(0.0, width), ylim=(0.0, height), aspect="equal", xticks=[], yticks=[])
    axis.spines[:].set_visible(False)


def counted(ratios: Mapping[str, float], near: float) -> str:
    """In how many cells a law is near the best."""
    mastered = [ratio for ratio in ratios.values() if not math.isnan(ratio)]
    return f"near best: {sum(ratio < near for ratio in mastered)} of {len(mastered)}"


def label(axis: Axes, grid: Grid, law: str, count: str, *, first: bool) -> None:
    axis.set_title(fill(law, NAME) + "\n", fontsize=7.5, pad=2)
    axis.text(0.5, 1.0, count, transform=axis.transAxes, ha="center", va="bottom", fontsize=6.5, color=SOFT)
    if first and grid.axes:
        axis.set_xlabel(f"{grid.axes[0].label} →", fontsize=6.5)
    if first and len(grid.axes) > 1:
        axis.set_ylabel(f"{grid.axes[1].label} →", fontsize=6.5)


def key() -> list[Patch]:
    """What the colours mean."""
    found = [Patch(facecolor=fill, label=name) for fill, name in zip(FILLS, NAMES, strict=True)]
    return [*found, Patch(facecolor="white", edgecolor=SOFT, hatch=HATCH, linewidth=0.3, label="lost")]
