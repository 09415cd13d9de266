"""What a run says."""

import tomllib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.control.metrics import Divergence
from hydroservo.core.field import Field
from hydroservo.core.formatting import brief, quantity, readable_unit
from hydroservo.core.outputs import write_text
from hydroservo.runs.behaviour import behaviour
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.divergence import BEYOND
from hydroservo.runs.provenance import origin_of
from hydroservo.runs.results import metric_fields, metrics_csv, metrics_of, save
from hydroservo.runs.titles import law_title
from hydroservo.runs.trace import Trace, dataset
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot

    Run = Trace | xr.Dataset

OF_JUMPS = ("settling_time", "overshoot", "demand_jumps")  # metrics that say nothing of a demand without any
CAPTION = "What is controlled and its demand, error and command; then pressures and estimates, if any."
LOST = "Gathered before the run was lost: they say nothing of the loop."
WELL = Line("The run did not diverge.", mark=Mark.GOOD)
INSIDE = Line("The run did not diverge, and the piston stayed inside its stroke.", mark=Mark.GOOD)


def run_finding(run: "Run", scenario: str = "", ending: str = ".csv") -> Finding:
    """What a run says.

    Args:
        run: what ``simulate`` returned.
        scenario: its name, if it has one.
        ending: of the file of its trajectory, which says its format.
    """
    about, metrics = about_of(run), numbers_of(run)
    tables = tomllib.loads(about["scenario"])
    rows = [
        [Cell(name), Cell(metrics[name], field.unit), Cell(), Cell(field.meaning)]
        for name, field in fields_of(run).items()
        if name not in Divergence._fields and (metrics.get("demand_jumps", True) or name not in OF_JUMPS)
    ]
    columns = (Column("metric"), Column("value"), UNIT, Column("meaning"))
    return Finding(
        title_of("Run", scenario or law_title(tables)),
        [*verdict(run), *steps_line(about), conditions_line(tables)],
        warnings_of(run),
        [Table("metrics", columns, rows, "Metrics of the run.", LOST if metrics["diverged"] else "")],
        [Picture("run", CAPTION, lambda: drawn(run))],
        summary(run, scenario),
        {
            f"trajectory{ending}": lambda path: save(as_dataset(run), path),
            "metrics.csv": lambda path: write_text(path, metrics_table([scenario], [run])),
        },
        [origin_of(scenario, about)],
    )


def about_of(run: "Run") -> Mapping[Any, Any]:
    """The attributes of a run."""
    return run.about if isinstance(run, Trace) else run.attrs


def numbers_of(run: "Run") -> Mapping[str, float | bool]:
    """The metrics of a run by name, in SI units."""
    return run.metrics if isinstance(run, Trace) else metrics_of(run)


def fields_of(run: "Run") -> Mapping[str, Field]:
    """The declaration of each metric by name."""
    return run.fields if isinstance(run, Trace) else metric_fields(run)


def as_dataset(run: "Run") -> "xr.Dataset":
    return dataset(run) if isinstance(run, Trace) else run


def drawn(run: "Run") -> "Plot":
    from hydroservo.figures.run import plot_run

    return plot_run(as_dataset(run))


def summary(run: "Run", scenario: str) -> dict[str, Any]:
    """What identifies a run, and its metrics in SI units."""
    about = about_of(run)
    return {
        "scenario": scenario,
        "hash": about["hash"],
        "version": about["version"],
        "seed": int(about["seed"]),
        "diverged_by": about["diverged_by"],
        "warnings": warnings_of(run),
        "metrics": dict(numbers_of(run)),
    }


def verdict(run: "Run") -> list[Line]:
    """Whether a run diverged and by what, left its stroke, oscillates, cavitates, or does not follow."""
    metrics, fields = numbers_of(run), fields_of(run)
    if metrics["diverged"]:
        cause, time = str(about_of(run)["diverged_by"]), quantity(metrics["diverged_at"], "s")
        what = cause if BEYOND in cause else f"{cause} stopped being finite"
        return [Line("The run diverged", f": {what} at {time}.", Mark.BAD)]
    doubts = [
        *following_line(metrics, fields),
        *(Line(text, mark=Mark.DOUBTFUL) for text in behaviour(metrics, fields)),
    ]
    if metrics.get("stroke_left"):
        low, high = (brief(1e3 * metrics[name], 5) for name in ("position_min", "position_max"))
        way = f": it went from {low} mm to {high} mm."
        return [*doubts, Line("The piston left its stroke", way, Mark.DOUBTFUL)]
    return [*doubts, INSIDE if "stroke_left" in metrics else WELL]


def following_line(metrics: Mapping[str, float | bool], fields: Mapping[str, Field]) -> list[Line]:
    """That a loop does not follow: its rms error is more than its demand moves."""
    error, reach = float(metrics.get("rms_error", 0.0)), float(metrics.get("demand_reach", 0.0))
    if not 0.0 < reach < error:
        return []
    unit = fields["rms_error"].unit
    sizes = f": its rms error is {quantity(error, unit)}, and its demand moves by {quantity(reach, unit)}."
    return [Line("The loop does not follow", f"{sizes} hydroservo tune looks for better gains.", Mark.BAD)]


def steps_line(about: Mapping[Any, Any]) -> list[Line]:
    """How many integration steps a run took, where it chose them, and how much that matters."""
    if "substeps" not in about:
        return []
    off = f"twice as many differ by {about['step_error']:.1e} of the machine's largest values"
    return [Line(f"{about['substeps']} substeps a sample; {off}.", mark=Mark.QUIET)]


def conditions_line(tables: Mapping[str, Any]) -> Line:
    """The machine and the demand of a run, how long and how often."""
    blocks = [
        str(tables.get(name, {}).get("type", name)) for name in ("plant", "valve", "supply", "reference")
    ]
    times = tables["simulation"]
    rate, factor = readable_unit("Hz", 1.0 / times["period"])
    lasting = f"{quantity(times['duration'], 's')} at {brief(factor / times['period'])} {rate}"
    return Line(f"{', '.join(blocks)}; {lasting}.", mark=Mark.QUIET)


def metrics_table(scenarios: Sequence[str], runs: "Sequence[Run]") -> str:
    """A row for each run in SI units: what identifies it, then its metrics."""
    import pandas as pd

    fields = {name: field for run in runs for name, field in fields_of(run).items()}
    rows = [summary(run, name) for run, name in zip(runs, scenarios, strict=True)]
    table = pd.DataFrame([{**row, **row["metrics"]} for row in rows])
    return metrics_csv(table.drop(columns=["metrics", "warnings"]), fields)
