"""What a search for limits leaves in its folder: the trajectory of each run, and what the report says."""

from functools import partial

from hydroservo.cli.files import OwnFiles
from hydroservo.cli.limit import limits_table
from hydroservo.cli.reporting import table_of
from hydroservo.figures.comparison import plot_comparison
from hydroservo.formatting import number
from hydroservo.limits import Limits
from hydroservo.reports.report import Picture, Report, origin_of
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.results import save


def limits_files(found: Limits) -> OwnFiles:
    """The trajectory of each run."""
    return {f"{name}.csv": partial(save, data) for name, data in found._asdict().items()}


def limit_report(command: str, scenario: str, found: Limits) -> Report:
    """The report of limits.

    Args:
        command: makes it again.
        scenario: as the user named it.
        found: what ``limit`` returned.
    """
    times = " and ".join(
        f"{number(multiple)} times the {name} limit" for name, multiple in found.multiples().items()
    )
    remarks = [line for data in found for line in warnings_of(data)]
    picture = plot_comparison([*found], [*found._fields])
    return Report(
        f"Limits of {scenario}",
        [f"The law leaves {times}."] if times else [],
        list(dict.fromkeys(remarks)),
        [Picture("limit", "The law, and the best commands: what is controlled, error and command.", picture)],
        [table_of("limits", limits_table(scenario, found), "What each command leaves.")],
        command,
        [origin_of(scenario, found.law.attrs)],
    )
