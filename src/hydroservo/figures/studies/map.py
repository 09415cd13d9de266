"""Who wins where: a cell of a map for each cell of a study."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from hydroservo.figures.studies.grid import (
    CHARACTER,
    TEXT_WIDTH,
    CellPlace,
    MapGrid,
    label_axes,
    label_panels,
)
from hydroservo.figures.studies.looks import (
    SOFT,
    TIE,
    family_colours,
    fix_layout,
    ink_on,
    observer_marks,
    paler,
)
from hydroservo.figures.style import Plot, figure, style

MARGINS = (1.0, 1.1, 1.25, 1.5, 2.0)  # of the next family's error over the winner's; each begins a colour
STRENGTHS = (0.28, 0.46, 0.64, 0.82, 1.0)  # of the family's colour
CELL_WIDTH, CELL_HEIGHT = 0.62, 0.3  # inch, at most
LOWEST = 1.25  # inch, a panel with a heading beside it
STRIP = 0.2  # of a cell's height: the families that tie
MARK = 3.6  # points
KEY_ROW = 0.19  # inch
HATCH = "/////"


class Winner(NamedTuple):
    """Who wins a cell on test.

    ``families`` is the winner's, or in a tie all that it cannot be told from, best first; none where no law
    stays stable.
    """

    cell: str
    families: Sequence[str]
    observer: str  # of the best law; empty where it has none
    margin: float  # [-] the next family's error over the winner's; inf where no other stays stable


def plot_map(grid: MapGrid, winners: Sequence[Winner], families: Sequence[str]) -> Plot:
    """A map of winners: colour says the family, its strength the margin, a mark the winner's observer.

    Grey is a tie, with a strip of the colours of those that tie. Hatched is where no law stays stable.
    """
    colours = family_colours(families)
    shown = [family for family in colours if any(family in winner.families for winner in winners)]
    marks = observer_marks(sorted({winner.observer for winner in winners if winner.families}))
    with style(maths=False):
        fig, panels, key = panels_and_key(grid, len(shown), len(marks))
        places = grid.places()
        for winner in sorted(winners, key=lambda one: places[one.cell]):
            place = places[winner.cell]
            draw_winner(panels[place.row][place.column], place, winner, colours, marks)
        for row, axes in enumerate(panels):
            for column, axis in enumerate(axes):
                label_axes(axis, grid, bottom=row == len(panels) - 1, left=column == 0)
                shape_panel(axis, grid)
        label_panels(panels[0][0].figure, panels, grid)
        draw_margins(key[0], {family: colours[family] for family in shown})
        draw_signs(key[1], marks)
        fix_layout(fig)
    return fig


def panels_and_key(
    grid: MapGrid, families: int, observers: int
) -> tuple[Plot, Sequence[Sequence[Axes]], tuple[Axes, Axes]]:
    """Empty panels, and two axes below them for what colours and signs mean."""
    rows, columns = len(grid.rows), len(grid.columns)
    tall = rows * (panel_height(grid) + 0.14) + (0.7 if any(grid.columns) else 0.5)
    low = 0.4 + KEY_ROW * max(families, 4 if observers else 2)
    fig = figure(tall + low)
    above, below = fig.subfigures(2, 1, squeeze=False, height_ratios=[tall, low])[:, 0]
    panels = above.subplots(rows, columns, squeeze=False)
    left, right = below.subplots(1, 2)
    return fig, panels.tolist(), (left, right)


def shape_panel(axis: Axes, grid: MapGrid) -> None:
    """Keep few cells from growing wide."""
    across, _ = grid.inside
    if len(across) * len(grid.columns) * CELL_WIDTH < TEXT_WIDTH:
        axis.set_box_aspect(panel_height(grid) / (len(across) * CELL_WIDTH))
        axis.set_anchor("W")


def panel_height(grid: MapGrid) -> float:
    """In inch, with room for what is written beside a panel."""
    _, up = grid.inside
    beside = LOWEST if any(grid.rows) else 0.0
    upwards = len(grid.axes[1].label) * CHARACTER / len(grid.rows) if len(grid.axes) > 1 else 0.0
    return max(len(up) * CELL_HEIGHT, beside, upwards)


def draw_winner(
    axis: Axes, place: CellPlace, winner: Winner, colours: Mapping[str, str], marks: Mapping[str, str]
) -> None:
    left, bottom = place.x - 0.5, place.y - 0.5
    if not winner.families:
        hatched = Rectangle((left, bottom), 1, 1, facecolor="white", edgecolor=SOFT, hatch=HATCH, linewidth=0)
        axis.add_patch(hatched)
        axis.add_patch(Rectangle((left, bottom), 1, 1, fill=False, edgecolor="white", linewidth=1.2))
        return
    tie = len(winner.families) > 1
    fill = TIE if tie else shade(colours[winner.families[0]], winner.margin)
    axis.add_patch(Rectangle((left, bottom), 1, 1, facecolor=fill, edgecolor="white", linewidth=0.8))
    if tie:
        step = 0.92 / len(winner.families)
        for index, family in enumerate(winner.families):
            corner = (left + 0.04 + index * step, bottom + 0.05)
            axis.add_patch(Rectangle(corner, step, STRIP, facecolor=colours[family], linewidth=0))
    if winner.observer:
        up = 0.5 * STRIP if tie else 0.0
        (mark,) = axis.plot(place.x, place.y + up, marks[winner.observer], markersize=MARK)
        mark.set(markeredgewidth=0.7, markerfacecolor="none", markeredgecolor=ink_on(fill))


def shade(colour: str, margin: float) -> str:
    """The family's colour, paler where the next is near."""
    return paler(colour, STRENGTHS[sum(margin >= least for least in MARGINS[1:])])


def draw_margins(axis: Axes, colours: Mapping[str, str]) -> None:
    """What the colours mean: a row a family, a column a range of margins."""
    if not colours:
        axis.set_axis_off()
        return
    for row, colour in enumerate(colours.values()):
        for column, least in enumerate(MARGINS):
            axis.add_patch(
                Rectangle((column, row), 1, 1, facecolor=shade(colour, least), edgecolor="white", linewidth=1)
            )
    axis.set_xlim(0, len(MARGINS))
    axis.set_ylim(len(colours), 0)
    axis.set_yticks([row + 0.5 for row in range(len(colours))], list(colours))
    axis.xaxis.tick_top()
    axis.xaxis.set_label_position("top")
    axis.set_xticks([*range(len(MARGINS))], [f"{least:g}" for least in MARGINS])
    axis.set_xlabel("error of the next family over the winner's", fontsize=8)
    axis.tick_params(length=0, pad=2)
    axis.grid(visible=False)
    axis.spines[:].set_visible(False)


def draw_signs(axis: Axes, marks: Mapping[str, str]) -> None:
    """What grey, hatched and the marks mean."""
    axis.set_axis_off()
    fills = [
        Patch(facecolor=TIE, label="tie, and between whom"),
        Patch(facecolor="white", edgecolor=SOFT, hatch=HATCH, linewidth=0, label="no law stays stable"),
    ]
    axis.add_artist(axis.legend(handles=fills, loc="upper left", borderaxespad=0.0))
    signs = [
        Line2D([], [], marker=mark, linestyle="", color="black", label=name) for name, mark in marks.items()
    ]
    for sign in signs:
        sign.set(markersize=4.5, markeredgewidth=0.8, markerfacecolor="none")
    if signs:
        across = min(len(signs), 3)
        axis.legend(
            handles=signs,
            loc="lower left",
            ncols=across,
            title="winner's observer",
            borderaxespad=0.0,
            alignment="left",
        )
