"""The files that a command leaves in its folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydroservo.cli.summary import RunSummary
from hydroservo.outputs import staged, write_text
from hydroservo.runs.results import METRICS, metric_fields, metrics_csv, save, write_metrics

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["comparison_files", "run_files", "write_comparison", "write_run"]


def run_files(folder: Path, ending: str) -> list[Path]:
    """What :func:`write_run` writes."""
    return [folder / name for name in (f"trajectory{ending}", "metrics.csv", METRICS, "run.png", "run.svg")]


def write_run(folder: Path, summary: RunSummary, dataset: "xr.Dataset", ending: str) -> list[Path]:
    """The trajectory, the metrics and the plot of a run, together; returns what was written."""
    from hydroservo.figures.run import plot_run
    from hydroservo.figures.style import save_figure

    with staged(folder, last=METRICS) as stage:
        save(dataset, stage / f"trajectory{ending}")
        write_text(stage / "metrics.csv", metrics_csv(table([summary]), metric_fields(dataset)))
        save_figure(plot_run(dataset), stage / "run", summary.hash)
        write_metrics(stage, summary._asdict())
    return run_files(folder, ending)


def comparison_files(folder: Path) -> list[Path]:
    """What :func:`write_comparison` writes."""
    return [folder / name for name in ("metrics.csv", METRICS, "comparison.png", "comparison.svg")]


def write_comparison(
    folder: Path,
    said: Mapping[str, Any],
    summaries: Sequence[RunSummary],
    datasets: Sequence["xr.Dataset"],
    labels: Sequence[str],
) -> list[Path]:
    """The metrics of several runs, how they compare and their plot, together; returns what was written."""
    from hydroservo.figures.comparison import plot_comparison
    from hydroservo.figures.style import save_figure

    fields = {name: field for dataset in datasets for name, field in metric_fields(dataset).items()}
    origin = " ".join(summary.hash for summary in summaries)
    with staged(folder, last=METRICS) as stage:
        write_text(stage / "metrics.csv", metrics_csv(table(summaries), fields))
        save_figure(plot_comparison(datasets, labels), stage / "comparison", origin)
        write_metrics(stage, said)
    return comparison_files(folder)


def table(summaries: Sequence[RunSummary]) -> "pd.DataFrame":
    """A row for each run: what identifies it, then its metrics."""
    import pandas as pd

    rows = [{**one._asdict(), **one.metrics} for one in summaries]
    return pd.DataFrame(rows).drop(columns=["metrics", "warnings"])
