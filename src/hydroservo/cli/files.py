"""The files that a command leaves in its folder."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo.cli.outcome import Outcome, as_json, as_object, metrics_csv
from hydroservo.results import atomic_path, save

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["write_comparison", "write_run"]


def write_run(folder: Path, outcome: Outcome, dataset: "xr.Dataset", ending: str) -> list[Path]:
    """The trajectory, the metrics and the plot of a run; returns what was written."""
    from hydroservo.figures.run import plot_run
    from hydroservo.figures.style import save_figure

    return [
        save(dataset, folder / f"trajectory{ending}"),
        write_text(folder / "metrics.csv", metrics_csv([outcome])),
        write_text(folder / "metrics.json", as_json(as_object(outcome))),
        *save_figure(plot_run(dataset), folder / "run"),
    ]


def write_comparison(
    folder: Path, outcomes: Sequence[Outcome], datasets: Sequence["xr.Dataset"], labels: Sequence[str]
) -> list[Path]:
    """The metrics of several runs and their common plot; returns what was written."""
    from hydroservo.figures.comparison import plot_comparison
    from hydroservo.figures.style import save_figure

    return [
        write_text(folder / "metrics.csv", metrics_csv(outcomes)),
        write_text(folder / "metrics.json", as_json({"runs": [as_object(outcome) for outcome in outcomes]})),
        *save_figure(plot_comparison(datasets, labels), folder / "comparison"),
    ]


def write_text(path: Path, text: str) -> Path:
    with atomic_path(path) as temporary:
        temporary.write_text(text.rstrip("\n") + "\n", encoding="utf-8", newline="\n")
    return path
