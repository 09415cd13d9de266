"""Where each claim of the paper holds and where it fails: a map of all conditions, and an overview."""

import math
from collections.abc import Mapping, Sequence
from itertools import product
from textwrap import fill
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from hydroservo.figures.style import Plot, figure, style
from hydroservo.papers.tsmc_eha_2021.claims import (
    CLAIMS,
    LITERAL,
    PERIODS,
    READINGS,
    REALISATIONS,
    REPRODUCED,
    SCALES,
    VALVES,
    Condition,
)
from hydroservo.papers.tsmc_eha_2021.report.names import DELTAS, mathematical, plain_signs
from hydroservo.papers.tsmc_eha_2021.study import Verdict

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
HOLDS, FAILS = "#2171b5", "#b35806"
RAMP = ("#f2f2f2", "#deebf7", "#c6dbef", "#9ecae1", "#6baed6", "#2171b5", "#08519c")
STEPS = (0.0, 1e-9, 0.2, 0.4, 0.6, 0.8, 0.999, 1.001)
TITLES = {"delta": "parameters", "realisation": "sgn", "period": "sample period"}
SHORT: dict[Any, str] = {**DELTAS, "as printed": "printed", "boundary layer": "layer", "10 ms lag": "lag"}


def draw_map(claims: "pd.DataFrame") -> Plot:
    """A panel for each claim with a cell for each condition, its colour the ratio of measured to allowed."""
    with style():
        fig = figure(height=9.4, width=11.0)
        axes = list(fig.subplots(5, 3).flat)
        for index, (axis, claim) in enumerate(zip(axes, CLAIMS, strict=False)):
            draw_cells(axis, claim_cells(claims, claim.name))
            axis.set_title(mathematical(f"{claim.name}: {claim.title}"), loc="left", fontsize=7)
            label_cells(axis)
            if index % 3 == 0:
                label_readings(axis)
        draw_key(axes[len(CLAIMS)])
        for axis in axes[len(CLAIMS) + 1 :]:
            axis.set_axis_off()
    return fig


def claim_cells(claims: "pd.DataFrame", name: str) -> NDArray[np.float64]:
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
    mark_cells(axis, ratios < 1.0, "o", 1.5)
    mark_cells(axis, ~np.isfinite(ratios), "x", 2.6)
    for x in (3, 6, 9, 12, 15):
        axis.axvline(x, color="white", linewidth=4.0 if x == 9 else 1.8)
    axis.axhline(3, color="white", linewidth=4.0)
    for condition, (line, _) in OUTLINES.items():
        outline_cell(axis, condition, line)
    axis.grid(visible=False)
    axis.invert_yaxis()
    axis.spines[:].set_visible(False)


def mark_cells(axis: Axes, where: NDArray[np.bool_], marker: str, size: float) -> None:
    """A white mark in some cells, so that they are told apart without colour."""
    row, column = np.nonzero(where)
    axis.plot(column + 0.5, row + 0.5, marker, color="white", markersize=size, markeredgewidth=0.8)


def outline_cell(axis: Axes, condition: Condition, line: Literal["-", ":"]) -> None:
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


def draw_overview(claims: "pd.DataFrame", verdicts: Sequence[Verdict]) -> Plot:
    """One row a claim: its verdict as reproduced and to the letter, and how often it holds, under what."""
    tables = {field: claim_shares(claims, field) for field in Condition._fields}
    with style():
        fig = figure(height=5.2, width=11.0)
        widths = [9.0, 2.8, 3.0, *(1.2 * table.shape[1] for table in tables.values())]
        axes = fig.subplots(1, len(widths), width_ratios=widths, sharey=True)
        draw_names(axes[0], verdicts)
        draw_marks(axes[1], verdicts)
        draw_counts(axes[2], verdicts)
        for axis, (field, table) in zip(axes[3:], tables.items(), strict=True):
            draw_shares(axis, field, table)
        for axis in axes:
            axis.tick_params(length=0)
            axis.grid(visible=False)
            axis.spines[:].set_visible(False)
            axis.xaxis.tick_top()
            axis.yaxis.set_visible(False)
            axis.set_ylim(len(verdicts) - 0.5, -0.5)
    return fig


def claim_shares(claims: "pd.DataFrame", field: str) -> "pd.DataFrame":
    """The part of all conditions in which each claim holds, for each value of one field of a condition."""
    table = claims.pivot_table(index="claim", columns=field, values="holds", aggfunc="mean", sort=False)
    return table.loc[[claim.name for claim in CLAIMS]]


def draw_names(axis: Axes, verdicts: Sequence[Verdict]) -> None:
    for y, verdict in enumerate(verdicts):
        axis.text(0.0, y, verdict.claim, va="center", fontsize=7.5, color="#555555")
        axis.text(0.26, y, mathematical(fill(verdict.title, 45)), va="center", fontsize=8)
    axis.set_xticks([])
    axis.set_title("claim", loc="left", fontsize=8)


def draw_marks(axis: Axes, verdicts: Sequence[Verdict]) -> None:
    for y, verdict in enumerate(verdicts):
        for x, holds in enumerate((verdict.reproduced, verdict.to_the_letter)):
            marker, colour = ("o", HOLDS) if holds else ("X", FAILS)
            axis.plot(x, y, marker, color=colour, markersize=8, markeredgewidth=0.0)
    axis.set_xlim(-0.7, 1.7)
    axis.set_xticks([0, 1], ["repro-\nduced", "to the\nletter"], fontsize=7)
    axis.set_title("● holds  ✖ fails", fontsize=8)


def draw_counts(axis: Axes, verdicts: Sequence[Verdict]) -> None:
    rows = np.arange(len(verdicts))
    total, holds = verdicts[0].total, [verdict.holds for verdict in verdicts]
    axis.barh(rows, [total] * len(rows), height=0.62, color="#eeeeee")
    axis.barh(rows, holds, height=0.62, color=HOLDS)
    for y, count in enumerate(holds):
        axis.text(0.98 * total, y, f"{count}", ha="right", va="center", fontsize=8)
    axis.set_xlim(0, total)
    axis.set_xticks([])
    axis.set_title(f"holds in (of {total})", fontsize=8)


def draw_shares(axis: Axes, field: str, table: "pd.DataFrame") -> None:
    """Percentages as numbers on a blue ground, the darker the more often the claim holds."""
    part = table.to_numpy(dtype=float)
    axis.pcolormesh(
        np.arange(part.shape[1] + 1) - 0.5,
        np.arange(part.shape[0] + 1) - 0.5,
        part,
        cmap=ListedColormap(RAMP),
        norm=BoundaryNorm(STEPS, len(RAMP)),
        edgecolors="white",
        linewidth=1.0,
    )
    for (y, x), value in np.ndenumerate(part):
        ink = "white" if value >= 0.8 else "#222222"
        axis.text(x, y, f"{100 * value:.0f}", ha="center", va="center", fontsize=7.5, color=ink)
    names = [SHORT.get(one, plain_signs(str(one))) for one in table.columns]
    axis.set_xticks(range(part.shape[1]), names, fontsize=6.5)
    axis.set_title(f"{TITLES.get(field, field)}, %", fontsize=8)
