"""The report as one page of HTML that refers to no other file."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, count
from typing import NamedTuple

from hydroservo._version import __version__
from hydroservo.show import Cell, Picture, Table
from hydroservo.show.page import environment
from hydroservo.show.table import Texts, note_of, texts_of, with_unit
from hydroservo.studies.report.captions import level_text
from hydroservo.studies.report.commands import Repeat
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.sentences import lead, listed, sentences
from hydroservo.studies.report.tables import laws_in

DIGITS = 5  # of a number that a command repeats


class Sheet(NamedTuple):
    """A table as the page shows it."""

    table: Table
    texts: Texts
    note: str
    number: int


def page(
    found: Findings,
    pictures: Sequence[tuple[Picture, str]],
    fingerprint: str,
    levels: Mapping[str, Sequence[Table]],
    cells: Mapping[str, Sequence[Table]],
    again: Mapping[tuple[str, str], Repeat],
    command: str,
) -> str:
    """The report's HTML.

    Args:
        found: what is reported.
        pictures: those that it has, and the content of each as an address.
        fingerprint: names the results.
        levels: the tables at each level of activity.
        cells: the tables of each cell.
        again: the commands that repeat numbers, by cell and law.
        command: makes the study again; empty where it is not known.
    """
    numbers = count(1)

    def sheets(tables: Iterable[Table]) -> list[Sheet]:
        return [Sheet(one, texts_of(one), note_of(one, "Bold:"), next(numbers)) for one in tables]

    template = environment("hydroservo.studies.report").get_template("report.html.j2")
    return template.render(
        found=found,
        version=__version__,
        fingerprint=fingerprint,
        lead=lead(found),
        sentences=sentences(found),
        pictures=pictures,
        laws=sheets(chain(*levels.values())),
        cells={name: sheets(tables) for name, tables in cells.items()},
        has_properties=any(one.properties for one in found.at.cells.values()),
        shown=level_text(found),
        command=command,
        repeats={name: repeat_rows(found, name, again) for name in cells},
        rules=rule_rows(found),
        confidence=f"{100.0 * found.verdicts.rules.confidence:g} %",
    )


def repeat_rows(
    found: Findings, cell: str, again: Mapping[tuple[str, str], Repeat]
) -> list[tuple[str, str, Repeat]]:
    """The laws of a cell whose numbers can be repeated, the number of each, and what repeats it."""
    commands = [(law, again[cell, law]) for law in laws_in(found, cell) if (cell, law) in again]
    return [(law, text_of_error(one.error, found.unit), one) for law, one in commands]


def text_of_error(error: float, unit: str) -> str:
    return "lost" if math.isinf(error) else with_unit(Cell(error, unit), DIGITS)


def rule_rows(found: Findings) -> list[tuple[str, str]]:
    """The rules of the comparison, and how much was asked."""
    rules = found.verdicts.rules
    percent = f"{100.0 * rules.confidence:g} %"
    rows = [
        (
            "intervals",
            f"{percent}, paired: all laws meet the same conditions; Holm's correction over all pairs of a "
            "cell at a level",
        ),
        (
            "a tie",
            f"the interval holds 1 after the correction, or the ratio is nearer to 1 than {rules.margin:g}",
        ),
        (
            "lost runs",
            "a law that loses surely fewer runs wins, whatever the errors; errors are compared where both "
            "have runs",
        ),
        (
            "out of the running",
            f"a law that loses more than {100.0 * rules.most_lost:g} % of its test runs in a cell",
        ),
        (
            "activity",
            "the command's total variation in percent of its range a second, geometric mean over conditions",
        ),
        (
            "own activity",
            f"of {found.reference}: that of the calmest of its gains whose error on validation is at most "
            f"{rules.margin:g} times its least",
        ),
        (
            "gains",
            "fronts searched on train conditions; at each level, of the points calm enough on validation, "
            "the one that loses the fewest runs and of these has the least error",
        ),
        ("seed of the bootstrap", f"{rules.seed}, {rules.resamples:,} draws, for shares of factors"),
    ]
    return [*rows, *((name, text) for name, text in study_size(found) if text)]


def study_size(found: Findings) -> list[tuple[str, str]]:
    """How much the study asked, as far as the manifest says."""
    conditions, search = found.manifest.get("conditions", {}), found.manifest.get("search", {})
    counts = [
        f"{conditions[split]} {split}" for split in ("train", "validation", "test") if split in conditions
    ]
    stress = ", ".join(f"{scale:g}" for scale in conditions.get("stress", ()))
    of_limits = found.manifest.get("limits", {}).get("conditions", 0)
    levels = ", ".join(f"{one:g}" for one in search.get("levels", ()))
    searches = f"at most {search['candidates']:,} candidates" if "candidates" in search else ""
    seeds = f"{search['seeds']} of each law" if search.get("seeds", 1) > 1 else "one of each law"
    return [
        ("conditions", f"{listed(counts)} in each cell" if counts else ""),
        ("kinds of conditions", ", ".join(map(str, found.manifest.get("kinds", ())))),
        ("stress", f"{stress} times the nominal uncertainty" if stress else ""),
        ("limits", f"of the first {of_limits} test conditions of each cell" if of_limits else ""),
        ("searches", f"{seeds}, {searches}" if searches else ""),
        ("levels of activity", f"{levels} times that of {found.reference}" if levels else ""),
    ]
