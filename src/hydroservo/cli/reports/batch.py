"""What the report of a batch says."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hydroservo.cli.batch_summary import BatchSummary, ranges_table, spreads_table, verdicts
from hydroservo.cli.reporting import sentences, table_of
from hydroservo.figures.batch import plot_batch
from hydroservo.reports.report import Picture, Report, origin_of
from hydroservo.runs.results import metric_fields

if TYPE_CHECKING:
    import xarray as xr

PICTURED = 10**7  # runs; the columns of more take up memory that a batch in parts does not need otherwise


def batch_report(
    command: str, summary: BatchSummary, table: "xr.Dataset", pictured: tuple[str, Sequence[str]], alone: str
) -> Report:
    """The report of a batch.

    Args:
        command: makes it again.
        summary: what of it is shown.
        table: of all runs.
        pictured: the metric of the picture, and the paths of what varied.
        alone: which run one would look at first, and the command that runs it alone.
    """
    fields = metric_fields(table)
    metric, varying = pictured
    drawn = [Picture("spread", caption(metric), plot_batch(table, varying, metric))] if small(summary) else []
    left_out = [] if drawn else ["A picture of so many runs is drawn by --out FILE.png alone."]
    spread = "How the metrics are spread over the runs."
    return Report(
        f"{summary.runs:,} runs of {summary.scenario}",
        [*sentences(verdicts(summary, fields)), f"{alone[:1].upper()}{alone[1:]}"],
        [*summary.warnings, *left_out],
        drawn,
        [
            table_of("varied", ranges_table(summary, table), f"What varied, drawn with seed {summary.seed}."),
            table_of("metrics", spreads_table(summary, fields), spread),
        ],
        command,
        [origin_of(summary.scenario, table.attrs)],
    )


def small(summary: BatchSummary) -> bool:
    """Whether a batch is small enough for a picture."""
    return summary.runs <= PICTURED


def caption(metric: str) -> str:
    return f"The metric {metric} of each run against each number that varied, and how it is spread."
