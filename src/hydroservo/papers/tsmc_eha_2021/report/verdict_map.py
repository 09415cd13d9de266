"""Where each claim of the paper holds and where it fails: a map of all conditions."""

import math
from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from hydroservo.figures.style import Plot, figure, style
from hydroservo.papers.tsmc_eha_2021.claims import CLAIMS
from hydroservo.papers.tsmc_eha_2021.conditions import (
    LITERAL,
    PERIODS,
    READINGS,
    REALISATIONS,
    REPRODUCED,
    SCALES,
    VALVES,
    Condition,
)
from hydroservo.papers.tsmc_eha_2021.report.names import DELTAS
from hydroservo.papers.tsmc_eha_2021.report.typeset import mathematical, plain_signs

if TYPE_CHECKING:
    import pandas as pd

ROWS = tuple(product(READINGS, SCALES))
COLUMNS = tuple(product(VALVES, PERIODS, REALISATIONS))

# Brewer's Blues and PuOr: told apart with any common colour vision. The last one is infinity.
EDGES = (0.0, 0.01, 0.1, 1.0, 10.0, 100.0, 1e300, math.inf)
FILLS = ("#08519c", "#4292c6", "#c6dbef", "#fee0b6", "#f1a340", "#b35806", "#3d2200")
BINS = (
    "holds, ratio below 0.01",
    "holds, 0.01 to 0.1",
    "holds, 0.1 to 1",
    "fails, 1 to 10",
    "fails, 10 to 100",
    "fails, above 100",
    "fails: diverged or no number",
)
KEY = (
    "ratio of what was measured to what is allowed\n"
    "white dot: holds; white cross: no finite ratio\n"
    "E, B, I: sgn explicit, boundary layer, implicit"
)
OUTLINES: Mapping[Condition, tuple[Literal["-", ":"], str]] = {
    REPRODUCED: ("-", "as reproduced"),
    LITERAL: (":", "to the letter of the print"),
}


def draw_map(claims: "pd.DataFrame") -> Plot:
    """A panel for each claim with a cell for each condition, its colour the ratio of measured to allowed."""
    with style():
        fig = figure(height=9.4, width=11.0)
        axes = list(fig.subplots(5, 3).flat)
        for index, (axis, claim) in enumerate(zip(axes, CLAIMS, strict=False)):
            draw_cells(axis, cells(claims, claim.name))
            axis.set_title(mathematical(f"{claim.name}: {claim.title}"), loc="left", fontsize=7)
            label_cells(axis)
            if index % 3 == 0:
                label_readings(axis)
        draw_key(axes[len(CLAIMS)])
        for axis in axes[len(CLAIMS) + 1 :]:
            axis.set_axis_off()
    return fig


def cells(claims: "pd.DataFrame", name: str) -> NDArray[np.float64]:
    """A claim's ratios as the map shows them: a row for each reading and sign of Delta, shape (6, 18)."""
    rows = claims[claims["claim"] == name]
    keys = rows[list(Condition._fields)].itertuples(index=False, name=None)
    ratios = {Condition(*key): ratio for key, ratio in zip(keys, rows["ratio"], strict=True)}
    return np.array(
        [
            [
                ratios[Condition(reading, scale, realisation, valve, period)]
                for valve, period, realisation in COLUMNS
            ]
            for reading, scale in ROWS
        ]
    )


def colour_class(ratio: float) -> int:
    """Which of ``FILLS`` and ``BINS`` a ratio belongs to."""
    return min(int(np.searchsorted(EDGES, ratio, side="right")) - 1, len(FILLS) - 1)


def draw_cells(axis: Axes, ratios: NDArray[np.float64]) -> None:
    colours = ListedColormap(FILLS)
    inside = np.where(np.isfinite(ratios), np.clip(ratios, 0.0, 1e299), 1e300)
    axis.pcolormesh(
        inside, cmap=colours, norm=BoundaryNorm(EDGES, len(FILLS)), edgecolors="white", linewidth=0.6
    )
    mark(axis, ratios < 1.0, "o", 1.5)
    mark(axis, ~np.isfinite(ratios), "x", 2.6)
    for x in (3, 6, 9, 12, 15):
        axis.axvline(x, color="white", linewidth=4.0 if x == 9 else 1.8)
    axis.axhline(3, color="white", linewidth=4.0)
    for condition, (line, _) in OUTLINES.items():
        outline(axis, condition, line)
    axis.grid(visible=False)
    axis.invert_yaxis()
    axis.spines[:].set_visible(False)


def mark(axis: Axes, where: NDArray[np.bool_], marker: str, size: float) -> None:
    """A white mark in some cells, so that they are told apart without colour."""
    row, column = np.nonzero(where)
    axis.plot(column + 0.5, row + 0.5, marker, color="white", markersize=size, markeredgewidth=0.8)


def outline(axis: Axes, condition: Condition, line: Literal["-", ":"]) -> None:
    row = ROWS.index((condition.reading, condition.delta))
    column = COLUMNS.index((condition.valve, condition.period, condition.realisation))
    edges: tuple[tuple[str, float, Literal["-", ":"]], ...] = (("white", 3.0, "-"), ("black", 1.5, line))
    for colour, width, dashes in edges:
        axis.add_patch(
            Rectangle(
                (column, row),
                1,
                1,
                fill=False,
                edgecolor=colour,
                linewidth=width,
                linestyle=dashes,
                clip_on=False,
                zorder=5,
            )
        )


def label_cells(axis: Axes) -> None:
    """Name columns by realisation (its initial), sample period and valve, rows by the parameters."""
    names = [realisation[0].upper() for _, _, realisation in COLUMNS]
    for start, (valve, period) in enumerate(product(VALVES, PERIODS)):
        names[3 * start + 1] += f"\n{plain_signs(period)}"
        if start % 3 == 1:
            names[3 * start + 1] += f"\n{valve} valve" if valve == "static" else f"\nvalve with {valve}"
    axis.set_xticks(np.arange(len(COLUMNS)) + 0.5, names, fontsize=6)
    axis.set_yticks(np.arange(len(ROWS)) + 0.5, [DELTAS[scale] for _, scale in ROWS], fontsize=6.5)
    axis.tick_params(length=0, pad=2)


def label_readings(axis: Axes) -> None:
    """Name the upper and the lower rows by their reading of the print."""
    for middle, reading in zip((1.5, 4.5), READINGS, strict=True):
        axis.annotate(
            reading,
            (0.0, middle),
            (-36, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            rotation=90,
            ha="center",
            va="center",
            fontsize=7,
        )


def draw_key(axis: Axes) -> None:
    axis.set_axis_off()
    handles = [Patch(color=fill, label=text) for fill, text in zip(FILLS, BINS, strict=True)]
    handles += [
        Patch(facecolor="none", edgecolor="black", linewidth=1.5, linestyle=line, label=text)
        for line, text in OUTLINES.values()
    ]
    key = axis.legend(
        handles=handles,
        title=KEY,
        loc="upper left",
        fontsize=6.5,
        title_fontsize=6.5,
        labelspacing=0.25,
        borderaxespad=0,
        alignment="left",
    )
    key.set_in_layout(False)
