"""What a run says: its law's name, its behaviour in sentences, and its numbers."""

import math
import tomllib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.control.metrics import Divergence
from hydroservo.control.monitors.cycles import GROWING
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.field import Field
from hydroservo.core.formatting import brief, quantity, readable_unit
from hydroservo.core.outputs import write_text
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.kernels import BEYOND
from hydroservo.runs.provenance import origin_of
from hydroservo.runs.results import metric_fields, metrics_csv, metrics_of, save, scenario_tables
from hydroservo.runs.trace import Trace, run_dataset
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot

    Run = Trace | xr.Dataset

VAPOUR = 1e4  # [Pa] absolute, down to which oil may lose air without losing its flow; chosen here
NOTHING = 100.0  # [Pa] below atmospheric pressure, that is none
LONG = 0.01  # s of low pressure that are worth a sentence

Metrics = Mapping[str, float | bool]


def is_oscillating(metrics: Metrics) -> bool:
    """Whether a run ends in an oscillation that does not die out."""
    return metrics.get("oscillation_command", 0.0) > 0.0


def oscillation_note(metrics: Metrics) -> str:
    """A few words about a sustained oscillation, for a title; empty where there is none."""
    if not is_oscillating(metrics):
        return ""
    return f"oscillates at {quantity(metrics['oscillation_frequency'], 'Hz')}"


def behaviour_lines(metrics: Metrics, fields: Mapping[str, Field]) -> list[str]:
    """Sentences about a run: oscillation, ringing, low pressure; none where it diverged."""
    if metrics["diverged"]:
        return []
    return [line for line in (oscillation_line(metrics, fields), pressure_line(metrics)) if line]


def oscillation_line(metrics: Metrics, fields: Mapping[str, Field]) -> str:
    if "oscillation_command" not in metrics:
        return ""
    command, frequency = metrics["oscillation_command"], metrics["oscillation_frequency"]
    if math.isnan(command):
        short = "The run is too short to tell whether the loop settles or hunts slowly"
        return f"{short}; hydroservo audit runs it longer."
    growth = metrics["oscillation_growth"]
    if not is_oscillating(metrics):
        if math.isnan(frequency):
            return ""
        rings = f"The loop rings at {quantity(frequency, 'Hz')}"
        return f"{rings}; each cycle is {abs(growth):.0%} smaller than the last."
    unit = fields["oscillation_amplitude"].unit
    signal = quantity(metrics["oscillation_amplitude"], unit)
    sizes = f"{signal} in the controlled signal and {quantity(command, 'V')} in the command"
    if growth > GROWING:
        return f"The loop oscillates at {quantity(frequency, 'Hz')} and still grows: {sizes} so far."
    return f"The loop oscillates for good at {quantity(frequency, 'Hz')}: {sizes}."


def pressure_line(metrics: Metrics) -> str:
    """That a chamber cavitates, or that air leaves its oil; empty where its pressure stays above."""
    time, lowest = metrics.get("low_pressure_time", 0.0), metrics.get("pressure_min", 0.0)
    if lowest < -ATMOSPHERE:
        return (
            f"A chamber is below absolute zero: its pressure falls to {quantity(lowest, 'Pa')}, where real "
            "oil cavitates, so that the run cannot be trusted."
        )
    if lowest <= VAPOUR - ATMOSPHERE:
        return f"A chamber cavitates: its pressure falls to {quantity(lowest, 'Pa')}, nearly a vacuum."
    if not (time > LONG and lowest < -NOTHING):
        return ""
    return (
        f"A chamber is below atmospheric pressure for {quantity(time, 's')}: it falls to "
        f"{quantity(lowest, 'Pa')}, where air leaves the oil."
    )


def controller_name(dataset: "xr.Dataset") -> str:
    """The type of a run's law, whatever wraps it: what its colour follows."""
    return law_types(scenario_tables(dataset)["controller"])[-1]


def controller_title(dataset: "xr.Dataset") -> str:
    """What plots call the controller of a run, such as "TSMC in ValveInversion"."""
    return law_title(scenario_tables(dataset))


def law_title(tables: Mapping[str, Any]) -> str:
    """The law of a scenario with its wrappers, such as "TSMC in ValveInversion"."""
    return " in ".join(reversed(law_types(tables["controller"])))


def law_types(table: Mapping[str, Any]) -> list[str]:
    """The types of a law's wrappers, outermost first, and of the law inside them."""
    inner = table.get("controller")
    return [str(table["type"]), *(law_types(inner) if isinstance(inner, Mapping) else [])]


OF_JUMPS = ("settling_time", "overshoot", "demand_jumps")  # metrics that say nothing of a demand without any
CAPTION = "What is controlled and its demand, error and command; then pressures and estimates, if any."
LOST = "Gathered before the run was lost: they say nothing of the loop."
WELL = Line("The run did not diverge.", mark=Mark.GOOD)
INSIDE = Line("The run did not diverge, and the piston stayed inside its stroke.", mark=Mark.GOOD)


def run_finding(run: "Run", scenario: str = "", ending: str = ".csv") -> Finding:
    """What a run says."""
    about, metrics = run_attributes(run), run_metrics(run)
    tables = tomllib.loads(about["scenario"])
    rows = [
        [Cell(name), Cell(metrics[name], field.unit), Cell(), Cell(field.meaning)]
        for name, field in run_metric_fields(run).items()
        if name not in Divergence._fields and (metrics.get("demand_jumps", True) or name not in OF_JUMPS)
    ]
    columns = (Column("metric"), Column("value"), UNIT, Column("meaning"))
    return Finding(
        title_of("Run", scenario or law_title(tables)),
        [*run_verdict(run), *steps_line(about), conditions_line(tables)],
        warnings_of(run),
        [Table("metrics", columns, rows, "Metrics of the run.", LOST if metrics["diverged"] else "")],
        [Picture("run", CAPTION, lambda: draw_run(run))],
        run_numbers(run, scenario),
        {
            f"trajectory{ending}": lambda path: save(as_dataset(run), path),
            "metrics.csv": lambda path: write_text(path, runs_csv([scenario], [run])),
        },
        [origin_of(scenario, about)],
    )


def run_attributes(run: "Run") -> Mapping[Any, Any]:
    return run.about if isinstance(run, Trace) else run.attrs


def run_metrics(run: "Run") -> Mapping[str, float | bool]:
    """The metrics of a run by name, in SI units."""
    return run.metrics if isinstance(run, Trace) else metrics_of(run)


def run_metric_fields(run: "Run") -> Mapping[str, Field]:
    """The declaration of each metric by name."""
    return run.fields if isinstance(run, Trace) else metric_fields(run)


def as_dataset(run: "Run") -> "xr.Dataset":
    return run_dataset(run) if isinstance(run, Trace) else run


def draw_run(run: "Run") -> "Plot":
    from hydroservo.figures.run import plot_run

    return plot_run(as_dataset(run))


def run_numbers(run: "Run", scenario: str) -> dict[str, Any]:
    """What identifies a run, and its metrics in SI units."""
    about = run_attributes(run)
    return {
        "scenario": scenario,
        "hash": about["hash"],
        "version": about["version"],
        "seed": int(about["seed"]),
        "diverged_by": about["diverged_by"],
        "warnings": warnings_of(run),
        "metrics": dict(run_metrics(run)),
    }


def run_verdict(run: "Run") -> list[Line]:
    """Whether a run diverged and by what, left its stroke, oscillates, cavitates, or does not follow."""
    metrics, fields = run_metrics(run), run_metric_fields(run)
    if metrics["diverged"]:
        cause, time = str(run_attributes(run)["diverged_by"]), quantity(metrics["diverged_at"], "s")
        what = cause if BEYOND in cause else f"{cause} stopped being finite"
        return [Line("The run diverged", f": {what} at {time}.", Mark.BAD)]
    doubts = [
        *following_line(metrics, fields),
        *(Line(text, mark=Mark.DOUBTFUL) for text in behaviour_lines(metrics, fields)),
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


def runs_csv(scenarios: Sequence[str], runs: "Sequence[Run]") -> str:
    """A row for each run in SI units: what identifies it, then its metrics."""
    import pandas as pd

    fields = {name: field for run in runs for name, field in run_metric_fields(run).items()}
    rows = [run_numbers(run, name) for run, name in zip(runs, scenarios, strict=True)]
    table = pd.DataFrame([{**row, **row["metrics"]} for row in rows])
    return metrics_csv(table.drop(columns=["metrics", "warnings"]), fields)
