"""The command that repeats a number: a law in a cell, with the gains of a search, under one condition."""

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.studies.choice import chosen, of_choice
from hydroservo.studies.columns import TRIED, judged_columns

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Repeat", "conditions_in", "repeats"]

ONE = [*TRIED, "effort"]  # set of gains
PLACE = ["law", "cell"]

Conditions = Mapping[str, Any]  # of a cell, by split and number: what each sets, and of which kind it is


class Repeat(NamedTuple):
    """A number, and the command that gives it again.

    Attributes:
        command: to be typed in the study's folder.
        condition: the test condition that it runs.
        error: what the metric was [SI]; inf where the run was lost.
    """

    command: str
    condition: int
    error: float


def repeats(
    table: "pd.DataFrame", conditions: Mapping[str, Conditions], plugins: Sequence[str] = ()
) -> dict[tuple[str, str], Repeat]:
    """The run in the middle of each law in each cell: the median error of all searches and test conditions.

    Of an even number it is the better one in the middle; a lost run's error counts as infinite.

    Args:
        table: the study's, with the column ``parameters``: JSON, path -> number in SI units.
        conditions: of each cell whose runs can be repeated.
        plugins: files with blocks of the study, seen from its folder.
    """
    runs = judged_columns(table)
    choice = chosen(runs)
    last = choice.groupby(PLACE, observed=True)["budget"].transform("max")
    tests = of_choice(runs, choice[choice["budget"] == last], "test")
    tests["error"] = tests["error"].fillna(math.inf)
    ordered = tests.sort_values([*PLACE, "error", "condition", "optimiser", "search_seed"])
    places = ordered.groupby(PLACE, observed=True)
    middle = ordered[places.cumcount() == (places["error"].transform("size") - 1) // 2]
    found = middle.merge(table[[*ONE, "parameters"]].drop_duplicates(ONE), on=ONE)
    names = [*PLACE, "condition", "error", "parameters"]
    return {
        (str(cell), str(law)): Repeat(
            command(
                str(cell), str(law), json.loads(gains), conditions[cell]["test"][str(condition)], plugins
            ),
            int(condition),
            float(error),
        )
        for law, cell, condition, error, gains in zip(*(found[name] for name in names), strict=True)
        if cell in conditions
    }


def command(
    cell: str, law: str, gains: Mapping[str, Any], condition: Mapping[str, Any], plugins: Sequence[str]
) -> str:
    """A line for a shell that stands in the study's folder."""
    words = ["hydroservo", "run", "--strict", f"scenarios/{cell}/{law}/{condition['kind']}.toml"]
    for plugin in plugins:
        words += ["--plugin", plugin]
    for path, value in {**gains, **condition["set"]}.items():
        words += ["--set", f"{path}={value!r}"]
    return shlex.join(words)


def conditions_in(folder: Path) -> dict[str, Conditions]:
    """The conditions of each cell, as a study's folder has them."""
    files = sorted((folder / "conditions").glob("*.json"))
    return {file.stem: json.loads(file.read_text("utf-8")) for file in files}
