"""Several runs side by side: in what they differ, which is best, and what they say."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.control.metrics import Divergence
from hydroservo.core.block import Block, field_at, is_under
from hydroservo.core.field import Field
from hydroservo.core.formatting import common_unit, yes_or_no
from hydroservo.core.outputs import write_text
from hydroservo.runs.arguments import checked_runs
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.provenance import origin_of
from hydroservo.runs.results import best_runs, metric_fields, metrics_of, scenario_tables
from hydroservo.runs.run_finding import INSIDE, OF_JUMPS, WELL, run_numbers, run_verdict, runs_csv
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot

ScenarioTable = Mapping[str, Any]

NO_CONDITION = ("controller", "simulation.record_period")  # what a comparison is of, and what no metric sees
ESTIMATES = ("estimate_rms_error_1", "estimate_rms_error_2")  # of disturbances against the law's own model


def differences(runs: Sequence["xr.Dataset"]) -> dict[str, tuple[Any, ...]]:
    """In what some runs differ besides their controllers: what must be empty for a fair comparison.

    The controller is the law with its wrappers, gains and model. All else is a condition: the machine, the
    demand and the load, sensors, the hold, sampling, integration, the seed; but not how often a run was
    recorded.

    Args:
        runs: a list of what ``simulate`` returned, at least one: ``differences([one, other])``.

    Returns:
        What each run has by dotted path in SI units. Where blocks differ in their type that is the names of
        the types, and of recorded signals a digest.

    Raises:
        ParameterError: they are something else.

    Fails to see that a condition has no effect, such as another seed where nothing is random.
    """
    return {
        path: values
        for path, values in unequal_values("", [scenario_as_given(run) for run in checked_runs(runs)])
        if not any(is_under(path, other) for other in NO_CONDITION)
    }


def winners(runs: Sequence["xr.Dataset"]) -> dict[str, set[int]]:
    """By metric, which runs have its best value; never one that diverged.

    None where more is not worse, where all are equal, and where runs differ in more than their controllers.
    An observer's errors are those of one quantity only where the models agree too.

    Args:
        runs: a list of what ``simulate`` returned, at least one.

    Raises:
        ParameterError: they are something else.
    """
    runs = checked_runs(runs)
    metrics, fair = [metrics_of(run) for run in runs], not differences(runs)
    same_model = not any(True for _ in unequal_values("", [law_model(run) for run in runs]))
    judged = {name for run in runs for name, field in metric_fields(run).items() if field.smaller_is_better}
    return {
        name: best_runs(metrics, name) if fair and (same_model or name not in ESTIMATES) else set()
        for name in judged
    }


def law_model(run: "xr.Dataset") -> ScenarioTable:
    """The model that the law of a run believes in, an empty table if it has none."""
    table = scenario_tables(run)["controller"]
    while "model" not in table and "controller" in table:
        table = table["controller"]
    found: ScenarioTable = table.get("model", {"type": ""})
    return found


def scenario_as_given(run: "xr.Dataset") -> ScenarioTable:
    """The scenario of a run, its substeps "auto" where the run chose them."""
    scenario = scenario_tables(run)
    return scenario | {
        "simulation": scenario["simulation"] | ({"substeps": "auto"} if "substeps" in run.attrs else {})
    }


def unequal_values(path: str, values: Sequence[Any]) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """What is not the same everywhere in nested tables, by path; one entry for tables of several types."""
    first = values[0]
    if not isinstance(first, Mapping):
        if not all(is_same(first, value) for value in values):
            yield path, tuple(values)
        return
    types = [(table.get("type", ", ".join(table)), table.get("module")) for table in values]
    if len(set(types)) > 1:
        distinct = len({name for name, _ in types}) == len(set(types))
        yield path, tuple(name if distinct or not module else f"{module}.{name}" for name, module in types)
        return
    for name in first:
        if name not in ("type", "module"):
            yield from unequal_values(f"{path}.{name}" if path else name, [table[name] for table in values])


def is_same(one: Any, other: Any) -> bool:
    return bool(one == other or (one != one and other != other))  # noqa: PLR0124 - not a number is itself


MOST_LINES = 8  # of single values; more are counted by table
NOTE = "of the runs that did not diverge"


def comparison_finding(
    runs: "Sequence[xr.Dataset]", scenarios: Sequence[str], labels: Sequence[str], loops: Sequence[Block] = ()
) -> Finding:
    """What several runs say side by side; the best are marked where only their controllers differ."""
    unequal = differences(runs)
    rows = comparison_rows(runs, winners(runs))
    columns = (Column("metric"), UNIT, *(Column(label, right=True) for label in labels))
    return Finding(
        f"Comparison of {', '.join(labels)}",
        [*comparison_verdicts(runs, labels), *unequal_lines(unequal, loops)],
        [f"{name}: {line}" for name, run in zip(scenarios, runs, strict=True) for line in warnings_of(run)],
        [Table("metrics", columns, rows, "Metrics of the runs.", best=NOTE)],
        [
            Picture(
                "comparison", "What is controlled, error and command.", lambda: draw_comparison(runs, labels)
            )
        ],
        {
            "runs": [run_numbers(run, name) for run, name in zip(runs, scenarios, strict=True)],
            "comparable": not unequal,
            "differences": unequal,
        },
        {"metrics.csv": lambda path: write_text(path, runs_csv(scenarios, runs))},
        [origin_of(name, run.attrs) for name, run in zip(scenarios, runs, strict=True)],
    )


def draw_comparison(runs: "Sequence[xr.Dataset]", labels: Sequence[str]) -> "Plot":
    from hydroservo.figures.run import plot_comparison

    return plot_comparison(runs, labels)


def comparison_verdicts(runs: "Sequence[xr.Dataset]", labels: Sequence[str]) -> list[Line]:
    """A line for each run that diverged, left its stroke, oscillates or does not follow."""
    lines = [
        line._replace(lead=f"{label}: {line.lead}")
        for label, run in zip(labels, runs, strict=True)
        for line in run_verdict(run)
        if line not in (WELL, INSIDE)
    ]
    stroke = " or left its stroke" if all("stroke_left" in run for run in runs) else ""
    return lines or [Line(f"No run diverged{stroke}.", mark=Mark.GOOD)]


def comparison_rows(runs: "Sequence[xr.Dataset]", best: Mapping[str, set[int]]) -> list[list[Cell]]:
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
        lines = [
            f"  {path}: {', '.join(value_texts(path, values, loops))}" for path, values in unequal.items()
        ]
    else:
        counts = Counter(path.partition(".")[0] for path in unequal)
        tables = ", ".join(f"{name} ({count})" for name, count in counts.items())
        lines = [f"  {len(unequal)} values in the tables {tables}; --json lists them"]
    first = Line("No run is marked best", ", for they differ in more than the controller:", Mark.DOUBTFUL)
    return [first, *map(Line, lines)]


def value_texts(path: str, values: Sequence[Any], loops: Sequence[Block]) -> list[str]:
    """What each run has at a path, numbers in a common unit and with as many digits as tell them apart."""
    numbers = [value for value in values if isinstance(value, float | int) and not isinstance(value, bool)]
    if len(numbers) < len(values):
        return [yes_or_no(value) if isinstance(value, bool) else str(value) for value in values]
    unit, factor = common_unit(numbers, field_at(loops[0], path).unit if loops else "")
    short, full = ([f"{factor * value:.{digits}g} {unit}".strip() for value in numbers] for digits in (5, 17))
    return short if len(set(short)) == len(set(numbers)) else full
