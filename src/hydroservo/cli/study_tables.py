"""A study's verdicts as tables of a terminal."""

from math import isnan
from typing import TYPE_CHECKING

from rich.table import Table

from hydroservo.cli.tables import show
from hydroservo.formatting import number, quantity
from hydroservo.studies.sentences import sentence

if TYPE_CHECKING:
    from hydroservo.studies.cell_verdict import CellVerdict
    from hydroservo.studies.running import Studied

__all__ = ["show_study"]

HEADS = (
    "law",
    "error, middle search",
    "its quartiles",
    "regret, all searches",
    "lost",
    "survives",
    "activity",
    "over the limit",
)


def show_study(found: "Studied") -> None:
    """A table a cell: each law's error over its searches, regret, lost runs, and what it survives.

    Where limits were sought it has the law's multiple of the clairvoyant one, on the conditions that have it.
    """
    for cell, verdict in found.verdicts.cells.items():
        show(cell_table(found, cell, verdict), sentence(verdict.best), "")


def cell_table(found: "Studied", cell: str, verdict: "CellVerdict") -> Table:
    """The laws of a cell, the best first."""
    levels = ", ".join(f"{axis} {level}" for axis, level in found.manifest["cells"][cell].items())
    table = Table(title=levels or str(found.manifest["title"]), title_justify="left")
    unit = found.manifest["unit"]
    least = verdict.limit.laws
    for name in HEADS if least else HEADS[:-1]:
        table.add_column(name, justify="left" if name == "law" else "right")
    order = sorted(verdict.standings, key=lambda law: verdict.regret[law])
    for law in order:
        one = verdict.standings[law]
        ends = f"{quantity(one.error_low, unit)} to {quantity(one.error_high, unit)}"
        tie = law in verdict.best.ties
        table.add_row(
            f"[bold]{law}[/bold]" if tie else law,
            quantity(one.error, unit),
            ends,
            f"{verdict.regret[law]:.2f}",
            f"{100.0 * one.lost.value:.1f} %",
            "-" if isnan(one.survived) else f"{one.survived:g} x",
            f"{one.activity:.1f} %/s",
            *([f"{number(least[law].clairvoyant)} times"] if least else []),
        )
    return table
