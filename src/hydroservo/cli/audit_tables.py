"""What an audit found, on the terminal."""

import math
from typing import TYPE_CHECKING

from rich.markup import escape
from rich.table import Table

from hydroservo.cli.tables import NO_NUMBER, show
from hydroservo.formatting import readable_unit

if TYPE_CHECKING:
    from hydroservo.assumptions import Assumption
    from hydroservo.audits import Audit

COLOURS = {True: "green", False: "bold red", None: "yellow"}
VERDICTS = {True: "[green]holds[/]", False: "[bold red]fails[/]", None: "[yellow]cannot be told[/]"}


def show_audit(scenario: str, found: "Audit") -> None:
    """The assumptions of a law, each with its margin, and what else is found."""
    show(assumptions_table(scenario, found), *lines_of(found))


def lines_of(found: "Audit") -> list[str]:
    """What the run shows, and the chatter that is foretold."""
    from hydroservo.audits.verdicts import verdicts

    return [f"[{COLOURS[one.good]}]{one.lead}[/]{escape(one.rest)}" for one in verdicts(found)]


def assumptions_table(scenario: str, found: "Audit") -> Table:
    """The assumptions of a law, each with its margin."""
    table = Table(title=escape(scenario), title_justify="left")
    table.add_column("block", no_wrap=True)
    table.add_column("it supposes that")
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column("bound", justify="right", no_wrap=True)
    table.add_column("margin", justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("worst", no_wrap=True)
    for one in found.asked:
        if not one.assumptions:
            why = "does not say what it supposes" if one.assumptions is None else "supposes nothing here"
            table.add_row(one.block, f"[dim]{why}[/]")
        for i, assumption in enumerate(one.assumptions or ()):
            table.add_row("" if i else one.block, *cells(assumption))
        table.add_section()
    return table


def cells(one: "Assumption") -> tuple[str, ...]:
    """A row but for its block."""
    unit, factor = readable_unit(one.unit, one.bound if math.isfinite(one.bound) else one.value)
    value, bound = (
        f"{factor * size:.4g} {unit}".strip() if math.isfinite(size) else "∞" if size > 0.0 else NO_NUMBER
        for size in (one.value, one.bound)
    )
    at = f"{one.at:.4g} s" if math.isfinite(one.at) else ""
    worst = f"run, {at}" if one.measured and at else "run" if one.measured else at
    return escape(one.meaning), value, bound, margin(one.margin), VERDICTS[one.holds], worst


def margin(factor: float) -> str:
    """A factor as it is read."""
    return NO_NUMBER if math.isnan(factor) else "∞" if math.isinf(factor) else f"{factor:.3g}"
