"""A study's verdicts as tables of a terminal."""

import math
from typing import TYPE_CHECKING

from rich.table import Table

from hydroservo.cli.tables import show
from hydroservo.formatting import NONE, number, quantity

if TYPE_CHECKING:
    from hydroservo.studies.cell_verdict import CellVerdict
    from hydroservo.studies.running import Studied

ABOUT = "Bold: the best law at that activity of the command, and those that tie with it."


def show_study(found: "Studied") -> None:
    """A table a cell: the error of each law at each level of activity."""
    for cell, activity in found.verdicts.activity.items():
        show(cell_table(found, cell, activity), ABOUT, "")


def cell_table(found: "Studied", cell: str, activity: float) -> Table:
    """The laws of a cell, the one with the least error first."""
    levels, unit = found.verdicts.levels, found.manifest["unit"]
    where = ", ".join(f"{axis} {level}" for axis, level in found.manifest["cells"][cell].items())
    table = Table(
        title=f"{where or found.manifest['title']}: {found.manifest['metric']} by activity of the command",
        title_justify="left",
    )
    table.add_column("law")
    for level in levels:
        table.add_column(f"\N{LESS-THAN OR EQUAL TO} {number(float(level) * activity)} %/s", justify="right")
    verdicts = [one.cells.get(cell) for one in levels.values()]
    least: dict[str, float] = {}
    for verdict in verdicts:
        for law, standing in verdict.standings.items() if verdict else ():
            error = math.inf if math.isnan(standing.error) else standing.error
            least[law] = min(least.get(law, math.inf), error)
    for law in sorted(least, key=lambda one: least[one]):
        table.add_row(law, *(error_text(verdict, law, unit) for verdict in verdicts))
    return table


def error_text(verdict: "CellVerdict | None", law: str, unit: str) -> str:
    """The error of a law at a level, and how many of its runs were lost."""
    standing = verdict.standings.get(law) if verdict else None
    if verdict is None or standing is None:
        return NONE
    if math.isnan(standing.error):
        return "lost"
    lost = standing.lost.value
    text = quantity(standing.error, unit) + (f" ({number(100.0 * lost, 2)} % lost)" if lost else "")
    return f"[bold]{text}[/bold]" if law in verdict.best.ties else text
