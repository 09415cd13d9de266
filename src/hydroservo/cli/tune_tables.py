"""What a search found: on the terminal, as JSON and as TOML."""

import math
from collections.abc import Sequence
from typing import Any

from rich.markup import escape
from rich.table import Table

from hydroservo._version import __version__
from hydroservo.block import field_at
from hydroservo.cli.tables import as_text
from hydroservo.formatting import NONE, Scale, quantity, scale_of, scales_of
from hydroservo.linear.reading import READ, read_as
from hydroservo.linear.standing import Change
from hydroservo.runs.aims import geometric_mean
from hydroservo.runs.tuned import Tuned
from hydroservo.scenario.task import Task

MARGINS = {
    name: READ[name] for name in ("oscillation_gain", "gain_margin", "phase_margin", "sensitivity_peak")
}


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
        "bounds": task.bounds._asdict() if task.bounds else None,
        "margins": [
            {"scenario": one.name, "before": one.before._asdict(), "after": one.after._asdict()}
            for one in found.margins
        ],
        "first_guess": found.guess._asdict() if found.guess else None,
        "front": [one._asdict() for one in found.front],
        "interrupted": found.interrupted,
        "unstable": list(found.unstable),
    }


def tables_of(task: Task, found: Tuned) -> list[Table]:
    """What the terminal shows: the values, their metric and, with bounds, the margins."""
    tables = [values_table(task, found), metrics_table(task, found)]
    return [*tables, margins_table(found)] if found.margins else tables


def margins_table(found: Tuned) -> Table:
    """The margins of each machine while it moves, before and after, and from which gain it oscillates."""
    shown = Table(title="\nMargins while moving", title_justify="left")
    shown.add_column("machine", overflow="fold")
    shown.add_column("values")
    for label, _ in MARGINS.values():
        shown.add_column(label, justify="right")
    for change in found.margins:
        for i, (label, standing) in enumerate((("before", change.before), ("after", change.after))):
            cells = [read_as(getattr(standing, name), unit, NONE) for name, (_, unit) in MARGINS.items()]
            shown.add_row(escape(change.name), label, *cells, end_section=i == 1)
    return shown


def remarks_of(task: Task, found: Tuned) -> list[str]:
    """Comments in the file of values: why they may not be those of the command beside them."""
    remarks = []
    if found.interrupted:
        done = found.runs // (task.aim.seeds * len(task.aim.loops))
        remarks.append(f"The search was interrupted after {done:,} candidates.")
    if no_better(task, found):
        remarks.append("They are no better than those of the scenario.")
    return remarks


def no_better(task: Task, found: Tuned) -> bool:
    """Whether the scenario's own values keep the bounds and are better."""
    effort = task.aim.effort
    return found.own.within and found.best.cost(effort) > found.own.cost(effort)


def lines_of(task: Task, found: Tuned) -> list[str]:
    """How much was simulated, and what there is to say of the values found."""
    lines = [f"{found.runs:,} closed loops were simulated."]
    if found.interrupted:
        lines.append("[bold yellow]INTERRUPTED[/]: the best of the candidates so far")
    lines += swinging(found.margins)
    if not found.own.within:
        lines.append("What the scenario has is beyond the bounds.")
    elif no_better(task, found):
        lines.append("[bold yellow]NO BETTER[/] than what the scenario has; give the search more candidates")
    if found.edges:
        paths = ", ".join(map(escape, found.edges))
        lines.append(f"[bold yellow]AT THE EDGE[/] of its range, so a wider one may hold better: {paths}")
    if found.unstable:
        names = "; ".join(map(escape, found.unstable))
        lines.append(f"[bold yellow]UNSTABLE[/] for small motions: {names}")
    return lines


def swinging(margins: Sequence[Change]) -> list[str]:
    """Which machines oscillated before."""
    return [
        f"{escape(one.name)} oscillated before: {quantity(one.before.oscillation_command, 'V')} of command."
        for one in margins
        if one.before.oscillation_command > 0.0
    ]


def values_table(task: Task, found: Tuned) -> Table:
    """The best values, those before, a first guess from the machine, and the ranges."""
    guess = found.guess.parameters if found.guess else {}
    shown = Table()
    shown.add_column("parameter", overflow="fold")
    for name in ("before", *(["first guess"] if guess else []), "best", "from", "to"):
        shown.add_column(name, justify="right", no_wrap=name != "first guess")
    shown.add_column("unit", no_wrap=True)
    units = {path: field_at(task.aim.loops[0], path).unit for path in found.parameters}
    columns = [found.own.parameters, *([guess] if guess else []), found.parameters]
    rows = {path: (*(one[path] for one in columns), *task.ranges[path]) for path in found.parameters}
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
    heading = escape(f"\n{aim.metric} [{scale.label}]{means}")
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
