"""Where each cell of a study lies in a map: its axes inside a panel, and those that tell panels apart."""

from collections.abc import Mapping, Sequence
from itertools import product
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

INSIDE = 2  # axes of a study that lie inside a panel
TEXT_WIDTH = 5.4  # inch that all panels of a row have
CHARACTER = 0.07  # inch
BESIDE = 20  # characters in a line beside a row of panels


class GridLevel(NamedTuple):
    """A value that an axis of a study takes."""

    name: str  # as cells have it
    label: str  # as axes show it


class GridAxis(NamedTuple):
    """What varies between the cells of a study."""

    name: str
    label: str
    levels: Sequence[GridLevel]


class CellPlace(NamedTuple):
    """Where a cell lies: row and column of its panel, then y (upwards) and x inside it."""

    row: int
    column: int
    y: int
    x: int


class MapGrid(NamedTuple):
    """The cells of a study and the axes on which they lie, as a map shows them.

    The first two axes lie inside a panel, across and upwards; the third makes columns of panels and all
    others rows. Any of them may be missing, and so may cells.
    """

    axes: Sequence[GridAxis]
    cells: Mapping[str, Mapping[str, str]]  # cell -> axis -> level

    @property
    def inside(self) -> tuple[Sequence[GridLevel], Sequence[GridLevel]]:
        """The levels across and upwards in a panel; one without a name where the axis is missing."""
        across, up = (axis_levels(self.axes, index) for index in range(INSIDE))
        return across, up

    @property
    def rows(self) -> Sequence[Sequence[str]]:
        """What is the same in a row of panels."""
        return level_lines(self.axes[INSIDE + 1 :])

    @property
    def columns(self) -> Sequence[Sequence[str]]:
        """What is the same in a column of panels."""
        return level_lines(self.axes[INSIDE : INSIDE + 1])

    def places(self) -> dict[str, CellPlace]:
        """Where each cell lies."""
        return {cell: self.place(levels) for cell, levels in self.cells.items()}

    def place(self, levels: Mapping[str, str]) -> CellPlace:
        at = [[level.name for level in axis.levels].index(levels[axis.name]) for axis in self.axes]
        row = 0
        for axis, index in zip(self.axes[INSIDE + 1 :], at[INSIDE + 1 :], strict=True):
            row = row * len(axis.levels) + index
        x, y, column = [*at, 0, 0, 0][: INSIDE + 1]
        return CellPlace(row, column, y, x)


def axis_levels(axes: Sequence[GridAxis], index: int) -> Sequence[GridLevel]:
    return axes[index].levels if index < len(axes) else (GridLevel("", ""),)


def level_lines(axes: Sequence[GridAxis]) -> Sequence[Sequence[str]]:
    """For each combination of levels a line for each axis."""
    return [*product(*([f"{axis.label}: {level.label}" for level in axis.levels] for axis in axes))]


def label_axes(axis: "Axes", grid: MapGrid, *, bottom: bool = True, left: bool = True) -> None:
    """Name the levels of a panel whose cells have their middles at whole numbers."""
    across, up = grid.inside
    axis.set_xlim(-0.5, len(across) - 0.5)
    axis.set_ylim(-0.5, len(up) - 0.5)
    axis.grid(visible=False)
    axis.spines[:].set_visible(True)
    axis.tick_params(length=0, labelbottom=bottom, labelleft=left)
    room = TEXT_WIDTH / len(grid.columns) / len(across) / CHARACTER
    upright = max(len(level.label) for level in across) > room
    axis.set_xticks(range(len(across)), [level.label for level in across], rotation=90 if upright else 0)
    axis.set_yticks(range(len(up)), [level.label for level in up])


def label_panels(fig: "FigureBase", panels: "Sequence[Sequence[Axes]]", grid: MapGrid) -> None:
    """Name the axes of the panels once, and beside each row and above each column what is the same there."""
    room = int(TEXT_WIDTH / len(grid.columns) / CHARACTER)
    for axis, heading in zip(panels[0], grid.columns, strict=True):
        axis.set_title("\n".join(fill(line, room) for line in heading), fontsize="medium")
    for row, heading in zip(panels, grid.rows, strict=True):
        if heading:
            beside = row[-1].secondary_yaxis("right")
            beside.set_yticks([])
            beside.spines["right"].set_visible(False)
            beside.set_ylabel(
                "\n".join(fill(line, BESIDE) for line in heading), rotation=270, va="bottom", labelpad=4
            )
    if grid.axes and len(grid.columns) > 1:
        fig.supxlabel(grid.axes[0].label, fontsize="medium")
    elif grid.axes:
        panels[-1][0].set_xlabel(grid.axes[0].label)
    if len(grid.axes) > 1:
        fig.supylabel(grid.axes[1].label, fontsize="medium")
