"""The picture of many runs: one metric against each number that varied, and how it is spread."""

import math
import re
from collections.abc import Sequence
from textwrap import fill
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import SUPERSCRIPT, readable_unit
from hydroservo.figures.panels import range_with_margin
from hydroservo.figures.style import PALETTE, Plot, figure, style

Numbers = NDArray[np.float64]

WIDEST = 3  # panels side by side
DOTS = 2000  # runs; more dots would hide each other, so that runs are counted in cells
CELLS = (36, 21)  # across and up
WIDE, MARGIN = 20.0, 1.2  # a metric that spans a larger ratio has a logarithmic axis, with a margin factor
FEWEST_BINS, MOST_BINS = 8, 40
ALIKE = 40  # runs for a quantile, of which two lie beyond 5 %, or for one point of a running one
FEWEST, MOST = 4, 20  # such points
QUANTILES = {0.05: "--", 0.5: "-", 0.95: "--"}  # and their lines
BIG_DOTS = 200  # runs; as many have room for dots of twice the size
DOT, EDGE = 3.5, 0.03  # points; share of the range beside the outermost dots
RUN, TREND, LOST = PALETTE[0], PALETTE[1], "#000000"
COUNTS = LinearSegmentedColormap.from_list("counts", ["#dcebf7", "#6baed6", RUN, "#08306b"])
LABELS = 60  # characters that all labels below a row of panels may take side by side
ABOVE = (1.02, 1.06)  # a panel
OWNERS = {"load": "load: ", "reference": "demand: ", "model": "model: "}  # of like numbers
MARKS = 200  # runs that diverged; more of them would hide each other, so that a strip shows their share
GREEK = {"beta": "beta", "delta": "delta", "eps": "varepsilon", "mu": "mu", "phi": "phi", "rho": "rho"}
NO_BREAK = "\N{NO-BREAK SPACE}"
SYMBOL = re.compile(r"\b([A-Za-z]+)_(\w+)\b|(?<=\s)([A-Za-z]|rho)(?=\N{NO-BREAK SPACE}|$)")


class BatchGrid(NamedTuple):
    """A figure's panels, and the axes of the distribution beside them."""

    fig: Plot
    panels: Sequence[Axes]
    beside: Axes


class ShownMetric(NamedTuple):
    """A metric of the runs that are shown, in the unit of its axis."""

    meaning: str
    unit: str
    values: Numbers
    kept: NDArray[np.bool_]  # which of all runs these are
    lost: NDArray[np.bool_]  # which diverged; the rest has no such metric


def plot_batch(table: xr.Dataset, varied: Sequence[str], metric: str) -> Plot:
    """A metric of many runs against each number that varied, and its distribution.

    Lines show the median and the 5 and 95 % of 40 runs or more: of all, and from 160 runs on of those with
    like values of that number, never beyond these. Runs that diverged are marked above the panels and are in
    nothing else. Many runs are counted in cells.

    Args:
        table: what ``simulate_batch`` returned.
        varied: the paths of what varied, columns of the table.
        metric: the name of a metric.
    """
    runs = shown_metric(table, metric)
    with style():
        grid = grid_for(len(varied))
        draw_distribution(grid, runs)
        for axis, path in zip(grid.panels, varied, strict=True):
            draw_runs_panel(axis, table[path], runs)
        for axis in grid.panels:
            plain_ticks(axis.yaxis)  # last, for each panel sets the common scale anew
        if is_counted(runs):
            count_alike(grid, runs)
        grid.fig.legend(handles=legend_handles(grid, runs), loc="outside upper center", ncols=4)
    return grid.fig


def shown_metric(table: xr.Dataset, metric: str) -> ShownMetric:
    """The values to show, in a unit that fits."""
    if metric not in table:
        raise ParameterError("metric", metric, "is not a metric of these runs")
    kept = ~table["diverged"].values & np.isfinite(table[metric].values)
    values, about = table[metric].values[kept], table[metric].attrs
    unit, factor = unit_scale(about["units"], values)
    return ShownMetric(about["long_name"], unit, factor * values, kept, table["diverged"].values)


def grid_for(count: int) -> BatchGrid:
    """Rows of so many panels, with the distribution beside the first; that alone where nothing is drawn."""
    if not count:
        fig = figure(2.4)
        return BatchGrid(fig, (), fig.subplots())
    rows = math.ceil(count / WIDEST)
    across = math.ceil(count / rows)
    fig = figure(0.6 + 1.9 * rows)
    spec = fig.add_gridspec(rows, across + 1, width_ratios=[1.0] * across + [0.15 + 0.08 * across])
    first = fig.add_subplot(spec[0, 0])
    others = [fig.add_subplot(spec[divmod(i, across)], sharey=first) for i in range(1, count)]
    return BatchGrid(fig, [first, *others], fig.add_subplot(spec[0, across], sharey=first))


def draw_distribution(grid: BatchGrid, runs: ShownMetric) -> None:
    """How many runs have which value: sideways beside panels, whose common range it sets."""
    axis, sideways = grid.beside, bool(grid.panels)
    low, high = metric_extent(runs.values)
    if spans_decades(runs.values):
        (axis.set_yscale if sideways else axis.set_xscale)("log")
    orientation: Literal["horizontal", "vertical"] = "horizontal" if sideways else "vertical"
    axis.hist(runs.values, edges_of(runs.values).tolist(), orientation=orientation, color=RUN, alpha=0.6)
    if has_enough_runs(runs):
        for quantile, line in QUANTILES.items():
            across = axis.axhline if sideways else axis.axvline
            across(float(np.quantile(runs.values, quantile)), color=TREND, linestyle=line)
    (axis.set_ylim if sideways else axis.set_xlim)(low, high)
    (axis.set_xlabel if sideways else axis.set_ylabel)("runs")
    crowded = runs.values.size > DOTS  # so that counts may have four digits
    ticks = MaxNLocator((1 if crowded else 3) if sideways else 6, integer=True)
    (axis.xaxis if sideways else axis.yaxis).set_major_locator(ticks)
    if sideways:
        axis.tick_params(labelleft=False, which="both")
    else:
        axis.set_xlabel(axis_label(runs.meaning, runs.unit, LABELS))
        plain_ticks(axis.xaxis)


def edges_of(values: Numbers) -> Numbers:
    """The edges of the bins in which runs are counted, the more runs the more, from least to largest."""
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    low, high = (low, high) if low < high else metric_extent(values)
    bins = min(max(math.ceil(2.0 * math.sqrt(values.size)), FEWEST_BINS), MOST_BINS)
    return np.geomspace(low, high, bins + 1) if spans_decades(values) else np.linspace(low, high, bins + 1)


def draw_runs_panel(axis: Axes, column: xr.DataArray, runs: ShownMetric) -> None:
    """The runs against one of the numbers that varied."""
    unit, factor = unit_scale(column.attrs["units"], column.values)
    x = factor * column.values
    edge = 0.0 if is_counted(runs) else EDGE * float(np.ptp(x))
    if is_counted(runs):
        spacing: Literal["log", "linear"] = "log" if spans_decades(runs.values) else "linear"
        axis.hexbin(x[runs.kept], runs.values, gridsize=CELLS, yscale=spacing, mincnt=1, cmap=COUNTS, lw=0.1)
    else:
        size = DOT if runs.values.size > BIG_DOTS else 2.0 * DOT
        axis.plot(x[runs.kept], runs.values, ".", color=RUN, markersize=size, markeredgewidth=0.0, alpha=0.6)
    draw_trend(axis, x[runs.kept], runs.values)
    mark_lost(axis, x, runs.lost)
    if np.ptp(x) > 0.0:
        axis.set_xlim(x.min() - edge, x.max() + edge)
    place = axis.get_subplotspec()
    across = place.get_gridspec().ncols - 1 if place is not None else 1
    parts = str(column.name).split(".")
    owner = next((name for part, name in OWNERS.items() if part in parts[:-1]), "")
    axis.set_xlabel(axis_label(owner + column.attrs["long_name"], unit, LABELS // across))
    if place is not None and place.is_first_col():
        axis.set_ylabel(axis_label(runs.meaning, runs.unit, LABELS // 2))
    else:
        axis.tick_params(labelleft=False, which="both")


def plain_ticks(axis: Axis) -> None:
    """Write 0.1 on a logarithmic axis, not a power of ten."""
    if axis.get_scale() == "log":
        axis.set_major_formatter(FuncFormatter(lambda tick, _: f"{tick:g}"))


def draw_trend(axis: Axes, x: Numbers, y: Numbers) -> None:
    """Quantiles of runs with like x, levelled where these rise or fall steeply."""
    points = min(x.size // ALIKE, MOST)
    if points < FEWEST:
        return
    log = spans_decades(y)
    parts = [(x[part], np.log(y[part]) if log else y[part]) for part in np.array_split(np.argsort(x), points)]
    middles = [float(near.mean()) for near, _ in parts]
    level = [levelled(near, values) for near, values in parts]
    for quantile, line in QUANTILES.items():
        found = [np.quantile(values, quantile) for values in level]
        trend = np.array([np.clip(one, y.min(), y.max()) for one, (_, y) in zip(found, parts, strict=True)])
        axis.plot(middles, np.exp(trend) if log else trend, line, color=TREND)


def levelled(x: Numbers, y: Numbers) -> Numbers:
    """Runs moved along their slope to the middle of x, where that takes away most of their range."""
    level = y - resistant_slope(x, y) * (x - x.mean())
    return level if quantile_span(level) < 0.5 * quantile_span(y) else y


def quantile_span(values: Numbers) -> float:
    low, high = np.quantile(values, (min(QUANTILES), max(QUANTILES)))
    return float(high - low)


def resistant_slope(x: Numbers, y: Numbers) -> float:
    """That of Tukey's resistant line, through the medians of the outer thirds, which no single run tilts."""
    third = max(x.size // 3, 1)
    (left, right), (low, high) = (
        (float(np.median(values[:third])), float(np.median(values[-third:]))) for values in (x, y)
    )
    return (high - low) / (right - left) if right > left else 0.0


def mark_lost(axis: Axes, x: Numbers, lost: NDArray[np.bool_]) -> None:
    """Marks above a panel where runs diverged; of many, a strip that is darker the more of them did."""
    above = axis.get_xaxis_transform()
    if not lost.any():
        return
    if lost.sum() > MARKS:
        every, edges = np.histogram(x, CELLS[0])
        share = np.histogram(x[lost], edges)[0] / np.maximum(every, 1)
        strip = axis.pcolormesh(edges, ABOVE, share[np.newaxis], cmap="Greys", vmin=0.0, transform=above)
        strip.set_clip_on(False)
    else:
        middles = np.full(lost.sum(), np.mean(ABOVE))
        (marks,) = axis.plot(x[lost], middles, "|", color=LOST, transform=above, clip_on=False)
        marks.set(markersize=5, markeredgewidth=0.6)


def count_alike(grid: BatchGrid, runs: ShownMetric) -> None:
    """One scale of counts for all panels."""
    clouds = [axis.collections[0] for axis in grid.panels]
    norm = LogNorm(1.0, max(float(np.max(np.asarray(cloud.get_array()))) for cloud in clouds))
    for cloud in clouds:
        cloud.set_norm(norm)
    bar = grid.fig.colorbar(clouds[0], ax=[*grid.panels, grid.beside], aspect=35, pad=0.01)
    bar.set_label(f"runs in a cell, of {runs.values.size:,}")
    plain_ticks(bar.ax.yaxis)


def legend_handles(grid: BatchGrid, runs: ShownMetric) -> list[Line2D]:
    shown, lost = runs.values.size, int(runs.lost.sum())
    few = "" if has_enough_runs(runs) else f"; fewer than {ALIKE} show no quantiles"
    label = f"{shown:,} run{'s' * (shown != 1)}{few}"
    dot = Line2D([], [], marker=".", linestyle="", color=RUN, label=label)
    lines = [
        Line2D([], [], color=TREND, label="median"),
        Line2D([], [], color=TREND, linestyle="--", label="5 % and 95 %"),
    ]
    mark = Line2D(
        [], [], marker="|", linestyle="", color=LOST, label=f"diverged: {lost:,} of {runs.kept.size:,}"
    )
    dots = [dot] if few or (grid.panels and not is_counted(runs)) else []
    return [*dots, *(lines if has_enough_runs(runs) else []), *([mark] if lost else [])]


def has_enough_runs(runs: ShownMetric) -> bool:
    """Enough runs for their quantiles to mean something."""
    return runs.values.size >= ALIKE


def is_counted(runs: ShownMetric) -> bool:
    return runs.values.size > DOTS


def spans_decades(values: Numbers) -> bool:
    return bool(values.size) and 0.0 < WIDE * float(values.min()) < float(values.max())


def metric_extent(values: Numbers) -> tuple[float, float]:
    """A range that holds all runs, with a margin."""
    if spans_decades(values):
        return float(values.min()) / MARGIN, float(values.max()) * MARGIN
    return range_with_margin([values], 0.0)


def unit_scale(unit: str, values: Numbers) -> tuple[str, float]:
    """The unit in which SI numbers are neither tiny nor huge, and the factor to it."""
    largest = float(np.max(np.abs(values), initial=0.0))
    label, factor = readable_unit(unit, largest)
    if largest == 0.0 or 1e-2 <= factor * largest < 1e5:
        return label, factor
    power = 3 * math.floor(math.log10(factor * largest) / 3.0)
    return f"10{str(power).translate(SUPERSCRIPT)} {label}".strip(), factor / 10.0**power


def axis_label(meaning: str, unit: str, width: int) -> str:
    """The name of an axis, in lines of so many characters, its symbols set as such.

    The unit that some meanings have in them is left out.
    """
    unit = f" [{unit}]".replace(" ", NO_BREAK) if unit else ""
    lines = fill(meaning.partition(" [")[0] + unit, width, break_long_words=False)
    return SYMBOL.sub(symbol_text, lines.replace("$", r"\$")).replace(NO_BREAK, " ")


def symbol_text(found: re.Match[str]) -> str:
    base, sub = found[1] or found[3], found[2]
    base = f"\\{GREEK[base]}" if base in GREEK else base
    return f"${base}_{{{sub}}}$" if sub else f"${base}$"
