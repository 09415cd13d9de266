"""What a search found: on the terminal, as JSON and as TOML."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w
from rich.markup import escape
from rich.table import Table

from hydroservo._version import __version__
from hydroservo.block import field_at
from hydroservo.cli.tables import as_text, show
from hydroservo.outputs import write_text
from hydroservo.readable import common_unit
from hydroservo.scenario.overrides import nested
from hydroservo.tuning import Aim, Tuned

__all__ = ["as_tables", "show_tuned", "write_values"]


def as_tables(scenarios: Sequence[str], command: Sequence[str], aim: Aim, found: Tuned) -> dict[str, Any]:
    """The result as nested tables, in SI units."""
    rows = zip(scenarios, aim.weights, found.before, found.after, strict=True)
    return {
        "command": " ".join(command),
        "version": __version__,
        "parameters": dict(found.parameters),
        "metric": aim.metric,
        "scenarios": [
            {"scenario": scenario, "weight": weight, "before": before, "after": after}
            for scenario, weight, before, after in rows
        ],
        "geometric_mean": found.cost,
        "runs": found.runs,
        "edges": list(found.edges),
    }


def write_values(file: Path, command: Sequence[str], found: Tuned) -> Path:
    """The values as TOML tables, under the command that found them."""
    text = " \\\n    ".join(command)
    comment = "".join(f"# {line}\n" for line in text.splitlines())
    tables = tomli_w.dumps(nested(found.parameters))
    return write_text(file, f"# In SI units, found by hydroservo {__version__} with\n{comment}\n{tables}")


def show_tuned(
    scenarios: Sequence[str], aim: Aim, ranges: Mapping[str, tuple[float, float]], found: Tuned
) -> None:
    """The values found with their ranges, and the metric of each scenario before and after."""
    show(values(aim, ranges, found), metrics(scenarios, aim, found))
    show(f"{found.runs:,} closed loops were simulated.")
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
        shown.add_row(escape(path), *(f"{one:.5g}" for one in (best, *ranges[path])), unit)
    return shown


def metrics(scenarios: Sequence[str], aim: Aim, found: Tuned) -> Table:
    unit, factor = common_unit(found.after, found.tables[0][aim.metric].attrs["units"])
    means = f", mean over {aim.seeds} seeds" if aim.seeds > 1 else ""
    heading = escape(f"{aim.metric} [{unit}]{means}")
    shown = Table(title=heading, title_justify="left")
    shown.add_column("scenario", overflow="fold")
    for name in ("weight", "before", "after", "change"):
        shown.add_column(name, justify="right", no_wrap=True)
    for scenario, weight, *pair in zip(scenarios, aim.weights, found.before, found.after, strict=True):
        shown.add_row(escape(scenario), f"{weight:g}", *(result(one, factor) for one in pair), change(*pair))
    if len(scenarios) > 1:
        both = [geometric_mean(aim.weights, one) for one in (found.before, found.after)]
        shown.add_row("geometric mean", "", *(result(one, factor) for one in both), change(*both))
    return shown


def geometric_mean(weights: Sequence[float], metrics: Sequence[float]) -> float:
    pairs = zip(weights, metrics, strict=True)
    return float(math.prod(metric ** (weight / sum(weights)) for weight, metric in pairs))


def result(metric: float, factor: float) -> str:
    return "diverged" if metric == math.inf else as_text(metric, factor)


def change(before: float, after: float) -> str:
    """How much larger a metric became, in per cent."""
    return f"{100.0 * (after / before - 1.0):+.3g} %" if 0.0 < before < math.inf else "-"
