"""The files that a command leaves in its folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydroservo.cli.summary import RunSummary
from hydroservo.results import as_json, metrics_csv, save, write_text

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["write_comparison", "write_run"]


def write_run(folder: Path, summary: RunSummary, dataset: "xr.Dataset", ending: str) -> list[Path]:
    """The trajectory, the metrics and the plot of a run; returns what was written."""
    from hydroservo.figures.run import plot_run
    from hydroservo.figures.style import save_figure

    return [
        save(dataset, folder / f"trajectory{ending}"),
        write_text(folder / "metrics.csv", metrics_csv(table([summary]))),
        write_text(folder / "metrics.json", as_json(summary._asdict()) + "\n"),
        *save_figure(plot_run(dataset), folder / "run"),
    ]


def write_comparison(
    folder: Path,
    said: Mapping[str, Any],
    summaries: Sequence[RunSummary],
    datasets: Sequence["xr.Dataset"],
    labels: Sequence[str],
) -> list[Path]:
    """The metrics of several runs, what a comparison says, and the common plot; returns what was written."""
    from hydroservo.figures.comparison import plot_comparison
    from hydroservo.figures.style import save_figure

    return [
        write_text(folder / "metrics.csv", metrics_csv(table(summaries))),
        write_text(folder / "metrics.json", as_json(said) + "\n"),
        *save_figure(plot_comparison(datasets, labels), folder / "comparison"),
    ]


def table(summaries: Sequence[RunSummary]) -> "pd.DataFrame":
    """A row for each run: what identifies it, then its metrics."""
    import pandas as pd

    return pd.DataFrame([{**one._asdict(), **one.metrics} for one in summaries]).drop(columns="metrics")
