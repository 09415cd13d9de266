"""What many runs of one loop say."""

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydroservo.control.metrics import Divergence, default_metric
from hydroservo.core.field import Field
from hydroservo.core.formatting import Scale, counted, number
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.provenance import origin_of
from hydroservo.runs.results import metric_fields, scenario_tables
from hydroservo.runs.run_finding import OF_JUMPS, conditions_line, law_title
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot

USUAL_METRIC = "steady_rms_error"
ENDS = (Column("from"), Column("to"), UNIT, Column("meaning"))
SPREAD = (*map(Column, ("5 %", "median", "95 %", "worst")), UNIT, Column("meaning"))


def batch_finding(
    table: "xr.Dataset",
    scenario: str = "",
    *,
    metric: str = "",
    typed: Mapping[str, Scale] = MappingProxyType({}),
    alone: str = "",
) -> Finding:
    """What many runs say."""
    fields = metric_fields(table)
    varied = varied_ranges(table)
    seed = int(table.attrs.get("drawn_with_seed", table.attrs["seed"]))
    metric = metric or default_metric(fields, USUAL_METRIC)
    runs = table.sizes["run"]
    tables = scenario_tables(table)
    caption = f"The metric {metric} of each run against each number that varied, and how it is spread."
    return Finding(
        f"{counted(runs, 'run')} of {scenario or law_title(tables)}",
        [*batch_verdicts(table), *remarkable_line(table, metric, alone), conditions_line(tables)],
        warnings_of(table),
        [
            Table(
                "varied",
                (Column("varied"), *ENDS),
                range_rows(table, varied),
                f"What varied, drawn with seed {seed}.",
                typed=typed,
            ),
            spread_table(table, fields),
        ],
        [Picture("spread", caption, lambda: draw_spread(table, metric))],
        batch_numbers(table, scenario, seed, varied),
        origins=[origin_of(scenario, table.attrs)],
    )


def draw_spread(table: "xr.Dataset", metric: str) -> "Plot":
    from hydroservo.figures.batch import plot_batch

    return plot_batch(table, [path for path in varied_ranges(table) if path != "simulation.seed"], metric)


def varied_ranges(table: "xr.Dataset") -> dict[str, tuple[float, float]]:
    """Between which ends each number was drawn, by its path; between which it lies where it was not."""
    if "varied" in table.attrs:
        return {path: (low, high) for path, (low, high) in json.loads(table.attrs["varied"]).items()}
    paths = [str(name) for name in table.data_vars if "." in str(name) and name != "simulation.seed"]
    return {
        path: (float(table[path].min()), float(table[path].max())) for path in paths if table.sizes["run"]
    }


def range_rows(table: "xr.Dataset", varied: Mapping[str, tuple[float, float]]) -> list[list[Cell]]:
    return [
        [Cell(path), *(Cell(end, about["units"]) for end in ends), Cell(), Cell(about["long_name"])]
        for path, ends in varied.items()
        for about in [table[path].attrs]
    ]


def spread_table(table: "xr.Dataset", fields: Mapping[str, Field]) -> Table:
    """How the metrics are spread over the runs."""
    jumps = "demand_jumps" not in table or bool(table["demand_jumps"].any())
    hidden = (*Divergence._fields, *(() if jumps else OF_JUMPS))
    rows = [
        [Cell(name), *(Cell(one, fields[name].unit) for one in spread), Cell(), Cell(fields[name].meaning)]
        for name, spread in spreads_of(table).items()
        if name not in hidden and not table["diverged"].all()
    ]
    note = "Of the runs that did not diverge." if table["diverged"].any() else ""
    title = "How the metrics are spread over the runs."
    return Table("metrics", (Column("metric"), *SPREAD), rows, title, note)


def remarkable_line(table: "xr.Dataset", metric: str, alone: str) -> list[Line]:
    """The run that one would look at first, and the command that runs it alone."""
    if not table.sizes["run"]:
        return []
    run, why = remarkable_run(table, metric)
    return [Line(f"Run {run} {why}.", " To run it alone:" if alone else "", command=alone)]


def remarkable_run(table: "xr.Dataset", metric: str) -> tuple[int, str]:
    """The run that one would look at first, and why: the first that diverged, else the worst."""
    lost = np.flatnonzero(table["diverged"].values)
    if lost.size:
        return int(lost[0]), "diverged"
    values = table[metric].values
    if not np.isfinite(values).any():
        return 0, "is the first"
    least = metric_fields(table)[metric].least_is_worst
    worst = np.nanargmin(values) if least else np.nanargmax(values)
    return int(worst), f"has the worst {metric}"


def batch_verdicts(table: "xr.Dataset") -> list[Line]:
    """How many runs diverged, left the stroke, and oscillate to the end."""
    counts = counts_in(table)
    lines = [
        Line(
            f"{count:,} of {counted(table.sizes['run'], 'run')} {what}",
            f" ({number(100.0 * count / table.sizes['run'])} %).",
            mark,
        )
        for what, count, mark in (
            ("diverged", counts["diverged"], Mark.BAD),
            ("left the stroke", counts["stroke_left"], Mark.DOUBTFUL),
            ("oscillated to the end", counts["oscillating"], Mark.DOUBTFUL),
        )
        if count
    ]
    stroke = ", and no piston left its stroke" if "stroke_left" in table else ""
    return lines or [Line(f"No run diverged{stroke}.", mark=Mark.GOOD)]


def counts_in(table: "xr.Dataset") -> dict[str, int]:
    """How many runs diverged, left the stroke, and oscillate to the end."""
    return {
        "diverged": int(table["diverged"].sum()),
        "stroke_left": int(table["stroke_left"].sum()) if "stroke_left" in table else 0,
        "oscillating": int((table["oscillation_command"] > 0.0).sum())
        if "oscillation_command" in table
        else 0,
    }


def batch_numbers(
    table: "xr.Dataset", scenario: str, seed: int, varied: Mapping[str, tuple[float, float]]
) -> dict[str, Any]:
    """What identifies a batch, what varied, and how its metrics are spread, in SI units."""
    return {
        "scenario": scenario,
        "hash": table.attrs["hash"],
        "version": table.attrs["version"],
        "seed": seed,
        "runs": table.sizes["run"],
        "varied": varied,
        "metrics": {name: spread._asdict() for name, spread in spreads_of(table).items()},
        **counts_in(table),
        "warnings": warnings_of(table),
    }


class Spread(NamedTuple):
    """How a metric is spread over the runs that did not diverge, in SI units; nan where none has it."""

    p05: float
    median: float
    p95: float
    worst: float


def spreads_of(table: "xr.Dataset") -> dict[str, Spread]:
    """How each metric of many runs is spread, by its name; flags have no spread."""
    kept, fields = ~table["diverged"].values, metric_fields(table)
    numbers = {name: field for name, field in fields.items() if table[name].dtype != bool}
    return {name: spread_of(field, table[name].values[kept]) for name, field in numbers.items()}


def spread_of(field: Field, values: np.ndarray) -> Spread:
    finite = values[np.isfinite(values)]
    if not finite.size:
        return Spread(*[float("nan")] * 4)
    worst = finite.min() if field.least_is_worst else finite.max()
    p05, median, p95 = map(float, np.quantile(finite, (0.05, 0.5, 0.95)))
    return Spread(p05, median, p95, float(worst))
