"""What several runs say side by side."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.control.metrics import Divergence
from hydroservo.core.block import Block, field_at
from hydroservo.core.field import Field
from hydroservo.core.formatting import common_unit, yes_or_no
from hydroservo.core.outputs import write_text
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.conditions import differences, winners
from hydroservo.runs.provenance import origin_of
from hydroservo.runs.results import metric_fields, metrics_of
from hydroservo.runs.run_finding import INSIDE, OF_JUMPS, WELL, metrics_table, summary, verdict
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot

MOST_LINES = 8  # of single values; more are counted by table
NOTE = "of the runs that did not diverge"


def comparison_finding(
    runs: "Sequence[xr.Dataset]", scenarios: Sequence[str], labels: Sequence[str], loops: Sequence[Block] = ()
) -> Finding:
    """What several runs say side by side; the best are marked where they differ in their controllers alone.

    Args:
        runs: what ``simulate`` returned for each.
        scenarios: their names.
        labels: what each is called in the table and the picture.
        loops: of the scenarios, for the units of numbers in which they differ.
    """
    unequal = differences(runs)
    rows = rows_of(runs, winners(runs))
    columns = (Column("metric"), UNIT, *(Column(label, right=True) for label in labels))
    return Finding(
        f"Comparison of {', '.join(labels)}",
        [*verdicts(runs, labels), *unequal_lines(unequal, loops)],
        [f"{name}: {line}" for name, run in zip(scenarios, runs, strict=True) for line in warnings_of(run)],
        [Table("metrics", columns, rows, "Metrics of the runs.", best=NOTE)],
        [Picture("comparison", "What is controlled, error and command.", lambda: drawn(runs, labels))],
        {
            "runs": [summary(run, name) for run, name in zip(runs, scenarios, strict=True)],
            "comparable": not unequal,
            "differences": unequal,
        },
        {"metrics.csv": lambda path: write_text(path, metrics_table(scenarios, runs))},
        [origin_of(name, run.attrs) for name, run in zip(scenarios, runs, strict=True)],
    )


def drawn(runs: "Sequence[xr.Dataset]", labels: Sequence[str]) -> "Plot":
    from hydroservo.figures.run import plot_comparison

    return plot_comparison(runs, labels)


def verdicts(runs: "Sequence[xr.Dataset]", labels: Sequence[str]) -> list[Line]:
    """A line for each run that diverged, left its stroke, oscillates or does not follow."""
    lines = [
        line._replace(lead=f"{label}: {line.lead}")
        for label, run in zip(labels, runs, strict=True)
        for line in verdict(run)
        if line not in (WELL, INSIDE)
    ]
    stroke = " or left its stroke" if all("stroke_left" in run for run in runs) else ""
    return lines or [Line(f"No run diverged{stroke}.", mark=Mark.GOOD)]


def rows_of(runs: "Sequence[xr.Dataset]", best: Mapping[str, set[int]]) -> list[list[Cell]]:
    """A row for each metric that some run has."""
    fields: dict[str, Field] = {name: field for run in runs for name, field in metric_fields(run).items()}
    metrics = [shown_metrics(run) for run in runs]
    rows = []
    for name, field in fields.items():
        if name in Divergence._fields:
            continue
        values = [one.get(name) for one in metrics]
        if any(value is not None for value in values):
            marked = best_as_read(values, best.get(name, set()), [bool(run["diverged"]) for run in runs])
            cells = [
                Cell(float("nan") if value is None else value, field.unit, Mark.BEST if i in marked else None)
                for i, value in enumerate(values)
            ]
            rows.append([Cell(name), Cell(), *cells])
    return rows


def shown_metrics(run: "xr.Dataset") -> dict[str, float | bool]:
    """The metrics of a run without those of jumps where its demand has none."""
    metrics = metrics_of(run)
    hidden = () if metrics.get("demand_jumps", True) else OF_JUMPS
    return {name: value for name, value in metrics.items() if name not in hidden}


def best_as_read(values: Sequence[float | None], best: set[int], diverged: Sequence[bool]) -> set[int]:
    """The best runs, with those whose number reads the same; none where all do."""
    texts = [
        "" if value is None or lost else f"{value:.3e}" for value, lost in zip(values, diverged, strict=True)
    ]
    shown = {texts[i] for i in best}
    same = {i for i, text in enumerate(texts) if text in shown}
    return same if len(same) < sum(map(bool, texts)) else set()


def unequal_lines(unequal: Mapping[str, tuple[Any, ...]], loops: Sequence[Block]) -> list[Line]:
    """In what runs differ besides their controllers, with the value in each; nothing where they do not."""
    if not unequal:
        return []
    if len(unequal) <= MOST_LINES:
        lines = [f"  {path}: {', '.join(texts_of(path, values, loops))}" for path, values in unequal.items()]
    else:
        counts = Counter(path.partition(".")[0] for path in unequal)
        tables = ", ".join(f"{name} ({count})" for name, count in counts.items())
        lines = [f"  {len(unequal)} values in the tables {tables}; --json lists them"]
    first = Line("No run is marked best", ", for they differ in more than the controller:", Mark.DOUBTFUL)
    return [first, *map(Line, lines)]


def texts_of(path: str, values: Sequence[Any], loops: Sequence[Block]) -> list[str]:
    """What each run has at a path, numbers in a common unit and with as many digits as tell them apart."""
    numbers = [value for value in values if isinstance(value, float | int) and not isinstance(value, bool)]
    if len(numbers) < len(values):
        return [yes_or_no(value) if isinstance(value, bool) else str(value) for value in values]
    unit, factor = common_unit(numbers, field_at(loops[0], path).unit if loops else "")
    short, full = ([f"{factor * value:.{digits}g} {unit}".strip() for value in numbers] for digits in (5, 17))
    return short if len(set(short)) == len(set(numbers)) else full
