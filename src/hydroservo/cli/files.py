"""The files that runs leave in their folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.cli.summary import RunSummary
from hydroservo.outputs import staged, write_text
from hydroservo.reports.folder import Files, write_report
from hydroservo.reports.journal import Journal
from hydroservo.reports.report import Report
from hydroservo.runs.results import METRICS, metric_fields, metrics_csv, save, write_metrics

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["Compared", "comparison_files", "run_files", "write_comparison", "write_run"]


def run_files(folder: Path, ending: str, journal: Journal) -> list[Path]:
    """What :func:`write_run` writes."""
    report = Files(["run"], ["metrics"], journal).names()
    return [folder / name for name in (f"trajectory{ending}", "metrics.csv", METRICS, *report)]


def write_run(
    folder: Path, summary: RunSummary, dataset: "xr.Dataset", ending: str, report: Report, journal: Journal
) -> list[Path]:
    """The trajectory, the metrics and the report of a run, together; returns what was written."""
    with staged(folder, last=METRICS) as stage:
        save(dataset, stage / f"trajectory{ending}")
        write_text(stage / "metrics.csv", metrics_csv(table([summary]), metric_fields(dataset)))
        write_report(stage, report, journal)
        write_metrics(stage, summary._asdict())
    return run_files(folder, ending, journal)


def comparison_files(folder: Path, journal: Journal) -> list[Path]:
    """What :func:`write_comparison` writes."""
    report = Files(["comparison"], ["metrics"], journal).names()
    return [folder / name for name in ("metrics.csv", METRICS, *report)]


class Compared(NamedTuple):
    """Several runs, and how they compare.

    Attributes:
        summaries: of each.
        datasets: of each.
        said: all of it in SI units, for JSON.
    """

    summaries: Sequence[RunSummary]
    datasets: Sequence["xr.Dataset"]
    said: Mapping[str, Any]


def write_comparison(folder: Path, compared: Compared, report: Report, journal: Journal) -> list[Path]:
    """The metrics of several runs, how they compare and their report, together; returns what was written."""
    fields = {name: field for data in compared.datasets for name, field in metric_fields(data).items()}
    with staged(folder, last=METRICS) as stage:
        write_text(stage / "metrics.csv", metrics_csv(table(compared.summaries), fields))
        write_report(stage, report, journal)
        write_metrics(stage, compared.said)
    return comparison_files(folder, journal)


def table(summaries: Sequence[RunSummary]) -> "pd.DataFrame":
    """A row for each run: what identifies it, then its metrics."""
    import pandas as pd

    rows = [{**one._asdict(), **one.metrics} for one in summaries]
    return pd.DataFrame(rows).drop(columns=["metrics", "warnings"])
