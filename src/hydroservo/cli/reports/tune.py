"""What the report of a search for gains says."""

import math

from hydroservo.cli.reporting import sentences, table_of
from hydroservo.cli.tune_tables import lines_of, margins_table, metrics_table, values_table
from hydroservo.figures.tuned import plot_front, plot_tuned
from hydroservo.formatting import quantity
from hydroservo.reports.report import Picture, Report, origin_of_loop
from hydroservo.runs.aims import geometric_mean
from hydroservo.runs.tuned import Tuned
from hydroservo.scenario.task import Task


def tune_report(command: str, task: Task, found: Tuned, replayed: str) -> Report:
    """The report of a search for gains.

    Args:
        command: makes it again.
        task: what was asked.
        found: what ``tune`` returned.
        replayed: the command that runs what was found.
    """
    metrics = table_of("metrics", metrics_table(task, found))
    return Report(
        f"Gains of {', '.join(task.scenarios)}",
        [changed(task, found), *sentences(lines_of(task, found)), f"{replayed[:1].upper()}{replayed[1:]}"],
        [],
        [
            Picture(
                "tuned",
                "The metric with the values the scenarios have, and with the best ones.",
                plot_tuned(found),
            ),
            Picture(
                "front",
                "The least error that candidates within the bounds have for the activity of their command.",
                plot_front(found),
            ),
        ],
        [
            table_of(
                "gains", values_table(task, found), "The best values, and the ranges that were searched."
            ),
            metrics._replace(title=f"Before and after: {metrics.title}."),
            *([table_of("margins", margins_table(found))] if found.margins else []),
        ],
        command,
        [origin_of_loop(name, loop) for name, loop in zip(task.names, task.aim.loops, strict=True)],
    )


def changed(task: Task, found: Tuned) -> str:
    """What became of the metric, in a sentence."""
    aim = task.aim
    what = (
        f"Geometric mean of {aim.metric} over {len(task.names)} loops" if len(task.names) > 1 else aim.metric
    )
    unit = found.tables[0][aim.metric].attrs["units"]
    means = [geometric_mean(aim.weights, one) for one in (found.before, found.after)]
    before, after = (quantity(one, unit) if math.isfinite(one) else "diverged" for one in means)
    return f"{what}: {before} before, {after} after."
