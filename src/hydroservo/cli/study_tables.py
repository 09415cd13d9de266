"""A study's verdicts as tables of a terminal."""

from typing import TYPE_CHECKING

from rich.table import Table

from hydroservo.cli.tables import show
from hydroservo.formatting import quantity

if TYPE_CHECKING:
    from hydroservo.studies.running import Studied

__all__ = ["show_study"]

ABOUT = "Bold: the least error of those so calm, and what nobody is surely better than."


def show_study(found: "Studied") -> None:
    """A table a cell: the error of each law at each level of activity."""
    for cell, activity in found.verdicts.activity.items():
        show(cell_table(found, cell, activity), ABOUT, "")


def cell_table(found: "Studied", cell: str, activity: float) -> Table:
    """The laws of a cell, the one with the least error first."""
    levels, unit = found.verdicts.levels, found.manifest["unit"]
    where = ", ".join(f"{axis} {level}" for axis, level in found.manifest["cells"][cell].items())
    title = f"{where or found.manifest['title']}: {found.manifest['metric']} at most so active"
    table = Table(title=title, title_justify="left")
    table.add_column("law")
    for level in levels:
        table.add_column(f"{quantity(float(level) * activity, '')} %/s", justify="right")
    standings = [one.cells[cell] for one in levels.values() if cell in one.cells]
    least: dict[str, float] = {}
    for own in standings:
        for law, standing in own.standings.items():
            least[law] = min(least.get(law, standing.error), standing.error)
    for law in sorted(least, key=lambda one: least[one]):
        texts = []
        for verdict in levels.values():
            at = verdict.cells.get(cell)
            there = at.standings.get(law) if at else None
            text = quantity(there.error, unit) if there else "cannot"
            texts.append(f"[bold]{text}[/bold]" if at and law in at.best.ties else text)
        table.add_row(law, *texts)
    return table
