"""The command that repeats a number: a law in a cell, with the gains of a search, under one condition."""

import json
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.studies.choice import choose_gains
from hydroservo.studies.columns import GAINS, judged_columns
from hydroservo.studies.report.findings import Findings

if TYPE_CHECKING:
    import pandas as pd

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
    table: "pd.DataFrame", found: Findings, conditions: Mapping[str, Conditions]
) -> dict[tuple[str, str], Repeat]:
    """The run in the middle of each law in each cell at the level shown: the median error of its test runs.

    Of an even number it is the better one in the middle; a lost run's error counts as infinite.

    Args:
        table: the study's, with the column ``parameters``: JSON, path -> number in SI units.
        found: what is reported.
        conditions: of each cell whose runs can be repeated.
    """
    levels = found.manifest["search"]["levels"]
    choice = choose_gains(judged_columns(table), found.reference, levels, found.verdicts.rules)
    own = choice[choice["level"] == float(found.level)]
    tests = table[table["split"] == "test"].merge(own, on=GAINS)
    ordered = tests.sort_values([*PLACE, "error", "condition"])
    places = ordered.groupby(PLACE, observed=True)
    middle = ordered[places.cumcount() == (places["error"].transform("size") - 1) // 2]
    plugins = found.manifest.get("plugins", ())
    names = [*PLACE, "condition", "error", "parameters"]
    return {
        (str(cell), str(law)): Repeat(
            command(
                str(cell), str(law), json.loads(gains), conditions[cell]["test"][str(condition)], plugins
            ),
            int(condition),
            float(error),
        )
        for law, cell, condition, error, gains in zip(*(middle[name] for name in names), strict=True)
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
