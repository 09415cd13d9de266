"""What a search found: on the terminal, as JSON and as TOML."""

import math
from collections.abc import Sequence
from typing import Any

from rich.markup import escape
from rich.table import Table

from hydroservo._version import __version__
from hydroservo.block import field_at
from hydroservo.cli.tables import as_text
from hydroservo.formatting import Scale, scale_of, scales_of
from hydroservo.runs.aims import geometric_mean
from hydroservo.runs.tuning import Tuned
from hydroservo.scenario.tuning import Task

__all__ = ["as_tables", "lines_of", "metrics_table", "values_table"]


def as_tables(command: Sequence[str], task: Task, found: Tuned) -> dict[str, Any]:
    """The result as nested tables, in SI units."""
    rows = zip(task.names, task.aim.weights, found.before, found.after, strict=True)
    return {
        "command": " ".join(command),
        "version": __version__,
        "parameters": dict(found.parameters),
        "metric": task.aim.metric,
        "scenarios": [
            {"scenario": scenario, "weight": weight, "before": before, "after": after}
            for scenario, weight, before, after in rows
        ],
        "geometric_mean": found.cost,
        "runs": found.runs,
        "edges": list(found.edges),
        "unstable": list(found.unstable),
    }


def lines_of(task: Task, found: Tuned) -> list[str]:
    """How much was simulated, and what there is to say of the values found."""
    lines = [f"{found.runs:,} closed loops were simulated."]
    weights = task.aim.weights
    if geometric_mean(weights, found.after) > geometric_mean(weights, found.before) and not task.aim.effort:
        lines.append("[bold yellow]NO BETTER[/] than what the scenario has; give the search more candidates")
    if found.edges:
        paths = ", ".join(map(escape, found.edges))
        lines.append(f"[bold yellow]AT THE EDGE[/] of its range, so a wider one may hold better: {paths}")
    if found.unstable:
        names = "; ".join(map(escape, found.unstable))
        lines.append(f"[bold yellow]UNSTABLE[/] about the operating point, as bode shows: {names}")
    return lines


def values_table(task: Task, found: Tuned) -> Table:
    """The values found, with their ranges."""
    shown = Table()
    shown.add_column("parameter", overflow="fold")
    for name in ("best", "from", "to"):
        shown.add_column(name, justify="right", no_wrap=True)
    shown.add_column("unit", no_wrap=True)
    units = {path: field_at(task.aim.loops[0], path).unit for path in found.parameters}
    rows = {path: (best, *task.ranges[path]) for path, best in found.parameters.items()}
    scales = scales_of(((units[path], values) for path, values in rows.items()), task.typed)
    for path, values in rows.items():
        scale = scales[units[path]]
        shown.add_row(escape(path), *(f"{scale.of(one):.5g}" for one in values), scale.label)
    return shown


def metrics_table(task: Task, found: Tuned) -> Table:
    """The metric of each scenario before and after."""
    aim = task.aim
    scale = scale_of(found.after, found.tables[0][aim.metric].attrs["units"])
    means = f", mean over {aim.seeds} seeds" if aim.seeds > 1 else ""
    heading = escape(f"{aim.metric} [{scale.label}]{means}")
    shown = Table(title=heading, title_justify="left")
    shown.add_column("scenario", overflow="fold")
    for name in ("weight", "before", "after", "change"):
        shown.add_column(name, justify="right", no_wrap=True)
    for scenario, weight, *pair in zip(task.names, aim.weights, found.before, found.after, strict=True):
        shown.add_row(escape(scenario), f"{weight:g}", *(result(one, scale) for one in pair), change(*pair))
    if len(task.names) > 1:
        both = [geometric_mean(aim.weights, one) for one in (found.before, found.after)]
        shown.add_row("geometric mean", "", *(result(one, scale) for one in both), change(*both))
    return shown


def result(metric: float, scale: Scale) -> str:
    return "diverged" if metric == math.inf else as_text(metric, scale)


def change(before: float, after: float) -> str:
    """How much larger a metric became, in per cent."""
    return f"{100.0 * (after / before - 1.0):+.3g} %" if 0.0 < before < math.inf else "-"
