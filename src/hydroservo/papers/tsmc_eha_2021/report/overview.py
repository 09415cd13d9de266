"""All verdicts on the paper's claims at a glance: one row a claim, and how often it holds under what."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap

from hydroservo.figures.style import Plot, figure, style
from hydroservo.papers.tsmc_eha_2021.claims import CLAIMS
from hydroservo.papers.tsmc_eha_2021.conditions import Condition
from hydroservo.papers.tsmc_eha_2021.report.names import DELTAS
from hydroservo.papers.tsmc_eha_2021.report.typeset import mathematical, plain_signs
from hydroservo.papers.tsmc_eha_2021.study import Verdict

if TYPE_CHECKING:
    import pandas as pd

HOLDS, FAILS = "#2171b5", "#b35806"
RAMP = ("#f2f2f2", "#deebf7", "#c6dbef", "#9ecae1", "#6baed6", "#2171b5", "#08519c")
STEPS = (0.0, 1e-9, 0.2, 0.4, 0.6, 0.8, 0.999, 1.001)
TITLES = {"delta": "parameters", "realisation": "sgn", "period": "sample period"}
SHORT: dict[Any, str] = {**DELTAS, "as printed": "printed", "boundary layer": "layer", "10 ms lag": "lag"}


def draw_overview(claims: "pd.DataFrame", verdicts: Sequence[Verdict]) -> Plot:
    """One row a claim: its verdict as reproduced and to the letter, and how often it holds, under what."""
    tables = {field: shares(claims, field) for field in Condition._fields}
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


def shares(claims: "pd.DataFrame", field: str) -> "pd.DataFrame":
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
