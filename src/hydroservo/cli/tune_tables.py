"""What a search found: on the terminal, as JSON and as TOML."""

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w
from rich.markup import escape
from rich.table import Table

from hydroservo.block import field_at
from hydroservo.cli.tables import as_text, show
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.readable import common_unit
from hydroservo.results import atomic_path
from hydroservo.tuning import LOST, Aim, Tuned, measured

__all__ = ["as_tables", "show_tuned", "write_values"]

WIDTH = 100  # characters a line of a comment
BEYOND = 1e-4 * LOST  # any metric of runs that were not lost, were there ten thousand seeds


def as_tables(scenarios: Sequence[str], command: str, aim: Aim, found: Tuned) -> dict[str, Any]:
    """The result as nested tables, in SI units."""
    return {
        "command": command,
        "parameters": dict(found.parameters),
        "metric": aim.metric,
        "scenarios": dict(zip(scenarios, found.metrics, strict=True)),
        "cost": found.cost,
        "runs": found.runs,
        "edges": list(found.edges),
    }


def write_values(file: Path, command: str, found: Tuned) -> None:
    """The values as TOML tables, under the command that found them."""
    table: dict[str, Any] = {}
    for path, value in found.parameters.items():
        *parents, name = path.split(".")
        inner = table
        for parent in parents:
            inner = inner.setdefault(parent, {})
        inner[name] = float(f"{value:.6g}")
    lines = textwrap.wrap(command, WIDTH, break_long_words=False, break_on_hyphens=False)
    comment = "".join(f"# {line}\n" for line in lines)
    with atomic_path(file) as temporary:
        temporary.write_text(f"# SI units. Found by:\n{comment}\n{tomli_w.dumps(table)}", encoding="utf-8")


def show_tuned(
    scenarios: Sequence[str], aim: Aim, ranges: Mapping[str, tuple[float, float]], found: Tuned
) -> None:
    """The values found with their ranges, and the metric of each scenario before and after."""
    show(values(aim, ranges, found), metrics(scenarios, aim, found))
    show(f"{found.runs:,} closed loops were simulated")
    if found.edges:
        paths = ", ".join(map(escape, found.edges))
        show(f"[bold yellow]AT THE EDGE[/] of its range, so a wider one may hold better: {paths}")


def values(aim: Aim, ranges: Mapping[str, tuple[float, float]], found: Tuned) -> Table:
    shown = Table()
    shown.add_column("parameter", overflow="fold")
    for name in ("best", "from", "to"):
        shown.add_column(name, justify="right", no_wrap=True)
    shown.add_column("unit", no_wrap=True)
    for path, best in found.parameters.items():
        unit = field_at(aim.loops[0], path).unit
        shown.add_row(escape(path), *(as_text(one, 1.0) for one in (best, *ranges[path])), unit)
    return shown


def metrics(scenarios: Sequence[str], aim: Aim, found: Tuned) -> Table:
    before = [float(one[0]) for one in measured(aim, {}, None)]
    unit, factor = common_unit(found.metrics, METRIC_FIELDS[aim.metric].unit)
    means = f", mean over {aim.seeds} seeds" if aim.seeds > 1 else ""
    shown = Table(title=f"{aim.metric} [{unit}]{means}".replace("[", r"\["), title_justify="left")
    shown.add_column("scenario", overflow="fold")
    for name in ("weight", "before", "after"):
        shown.add_column(name, justify="right", no_wrap=True)
    rows = zip(scenarios, aim.weights, before, found.metrics, strict=True)
    for scenario, weight, *pair in rows:
        shown.add_row(escape(scenario), f"{weight:g}", *(result(one, factor) for one in pair))
    return shown


def result(metric: float, factor: float) -> str:
    """A metric as text; a mean in which one run was lost says nothing."""
    return "diverged" if metric > BEYOND else as_text(metric, factor)
