"""What a run and a comparison leave in their folder: their own files, and what the report says."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from hydroservo.cli.files import OwnFiles
from hydroservo.cli.reporting import sentences, table_of
from hydroservo.cli.summary import RunSummary
from hydroservo.cli.tables import comparison_table, run_table, verdict, verdicts_of
from hydroservo.figures.comparison import plot_comparison
from hydroservo.figures.run import plot_run
from hydroservo.outputs import write_text
from hydroservo.reports.report import Picture, Report, origin_of
from hydroservo.runs.results import metric_fields, metrics_csv, save

if TYPE_CHECKING:
    import xarray as xr


def run_files(summary: RunSummary, dataset: "xr.Dataset", ending: str) -> OwnFiles:
    """The trajectory of a run, and its metrics as a table."""
    return {f"trajectory{ending}": partial(save, dataset), **comparison_files([summary], [dataset])}


def comparison_files(summaries: Sequence[RunSummary], datasets: "Sequence[xr.Dataset]") -> OwnFiles:
    """The metrics of several runs as a table."""
    return {"metrics.csv": lambda path: write_text(path, metrics_table(summaries, datasets))}


def metrics_table(summaries: Sequence[RunSummary], datasets: "Sequence[xr.Dataset]") -> str:
    """A row for each run in SI units: what identifies it, then its metrics."""
    import pandas as pd

    fields = {name: field for data in datasets for name, field in metric_fields(data).items()}
    rows = pd.DataFrame([{**one._asdict(), **one.metrics} for one in summaries])
    return metrics_csv(rows.drop(columns=["metrics", "warnings"]), fields)


def run_report(command: str, summary: RunSummary, dataset: "xr.Dataset", said: str) -> Report:
    """The report of one run.

    Args:
        command: makes it again.
        summary: what of it is shown.
        dataset: what ``simulate`` returned.
        said: what else is said of it; may be empty.
    """
    caption = "What is controlled and its demand, error and command; then pressures and estimates, if any."
    return Report(
        f"Run of {summary.scenario}",
        [*sentences(verdict(summary, metric_fields(dataset))), *filter(None, [said])],
        summary.warnings,
        [Picture("run", caption, plot_run(dataset))],
        [table_of("metrics", run_table(summary, metric_fields(dataset)), "Metrics of the run.")],
        command,
        [origin_of(summary.scenario, dataset.attrs)],
    )


def comparison_report(
    command: str,
    summaries: Sequence[RunSummary],
    datasets: "Sequence[xr.Dataset]",
    labels: Sequence[str],
    winners: Mapping[str, set[int]],
    unequal: Sequence[str],
) -> Report:
    """The report of several runs.

    Args:
        command: makes it again.
        summaries: what of each is shown.
        datasets: what ``simulate`` returned for each.
        labels: what each is called.
        winners: the best runs of each metric.
        unequal: in what else the runs differ, in lines.
    """
    fields = {name: field for one in datasets for name, field in metric_fields(one).items()}
    lost = sentences(verdicts_of(summaries, labels, fields))
    remarks = [
        f"{label}: {line}" for label, one in zip(labels, summaries, strict=True) for line in one.warnings
    ]
    return Report(
        f"Comparison of {', '.join(labels)}",
        lost or ["No run diverged or left its stroke."],
        [*(["\n".join(unequal)] if unequal else []), *remarks],
        [Picture("comparison", "What is controlled, error and command.", plot_comparison(datasets, labels))],
        [table_of("metrics", comparison_table(summaries, labels, fields, winners), "Metrics of the runs.")],
        command,
        [origin_of(one.scenario, data.attrs) for one, data in zip(summaries, datasets, strict=True)],
    )
