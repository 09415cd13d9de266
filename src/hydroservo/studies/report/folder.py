"""The report on a study: a folder with its pictures, and one page of HTML that opens offline."""

import hashlib
import json
import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo._version import __version__
from hydroservo.core.formatting import enumeration
from hydroservo.core.outputs import staged, write_text
from hydroservo.show import Cell, Picture, Table
from hydroservo.show.files import (
    FIGURES,
    METRICS,
    as_json,
    data_address,
    template_environment,
    write_figure,
    write_metrics,
    write_tables,
)
from hydroservo.show.journal import NO_JOURNAL, Journal, with_decimal_commas
from hydroservo.show.table import TableTexts, note_of, text_with_unit, texts_of
from hydroservo.studies.fronts import choose_gains
from hydroservo.studies.report.pictures import study_pictures
from hydroservo.studies.report.sentences import lead_sentence, sentences
from hydroservo.studies.report.tables import cell_tables, front_table, law_tables, ordered_laws_in
from hydroservo.studies.report.view import StudyView, level_text, study_view
from hydroservo.studies.trials import GAINS, judged_columns
from hydroservo.studies.verdicts import Verdicts

if TYPE_CHECKING:
    import pandas as pd

PLACE = ["law", "cell"]

CellConditions = Mapping[str, Any]  # of a cell, by split and number: what each sets, and of which kind it is
DIGITS = 5  # of a number that a command repeats
REPORT = "report.html"
VERDICTS = "verdicts.json"
PICTURES = "pictures"
VERSIONS = ("format", "hydroservo")  # what a store adds to a manifest


class Repeat(NamedTuple):
    """A number, and the command that gives it again."""

    command: str  # to be typed in the study's folder
    condition: int  # the test condition that it runs
    error: float  # what the metric was [SI]; inf where the run was lost


def repeat_commands(
    table: "pd.DataFrame", found: StudyView, conditions: Mapping[str, CellConditions]
) -> dict[tuple[str, str], Repeat]:
    """The run in the middle of each law in each cell at the level shown: the median error of its test runs.

    Of an even number it is the better one in the middle; a lost run's error counts as infinite. The column
    ``parameters`` of the table is JSON: numbers in SI units by path.
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
            shell_command(
                str(cell), str(law), json.loads(gains), conditions[cell]["test"][str(condition)], plugins
            ),
            int(condition),
            float(error),
        )
        for law, cell, condition, error, gains in zip(*(middle[name] for name in names), strict=True)
        if cell in conditions
    }


def shell_command(
    cell: str, law: str, gains: Mapping[str, Any], condition: Mapping[str, Any], plugins: Sequence[str]
) -> str:
    """A line for a shell that stands in the study's folder."""
    words = ["hydroservo", "run", "--strict", f"scenarios/{cell}/{law}/{condition['kind']}.toml"]
    for plugin in plugins:
        words += ["--plugin", plugin]
    for path, value in {**gains, **condition["set"]}.items():
        words += ["--set", f"{path}={value!r}"]
    return shlex.join(words)


def conditions_in(folder: Path) -> dict[str, CellConditions]:
    """The conditions of each cell, as a study's folder has them."""
    files = sorted((folder / "conditions").glob("*.json"))
    return {file.stem: json.loads(file.read_text("utf-8")) for file in files}


class Sheet(NamedTuple):
    """A table as the page shows it."""

    table: Table
    texts: TableTexts
    note: str
    number: int


def study_page(
    found: StudyView,
    pictures: Sequence[tuple[Picture, str]],
    fingerprint: str,
    levels: Mapping[str, Sequence[Table]],
    cells: Mapping[str, Sequence[Table]],
    again: Mapping[tuple[str, str], Repeat],
    command: str,
) -> str:
    """The report's HTML."""
    numbers = count(1)

    def sheets(tables: Iterable[Table]) -> list[Sheet]:
        return [Sheet(one, texts_of(one), note_of(one, "Bold:"), next(numbers)) for one in tables]

    template = template_environment("hydroservo.studies.report").get_template("report.html.j2")
    return template.render(
        found=found,
        version=__version__,
        fingerprint=fingerprint,
        lead=lead_sentence(found),
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
    found: StudyView, cell: str, again: Mapping[tuple[str, str], Repeat]
) -> list[tuple[str, str, Repeat]]:
    """The laws of a cell whose numbers can be repeated, the number of each, and what repeats it."""
    commands = [(law, again[cell, law]) for law in ordered_laws_in(found, cell) if (cell, law) in again]
    return [(law, text_of_error(one.error, found.unit), one) for law, one in commands]


def text_of_error(error: float, unit: str) -> str:
    return "lost" if math.isinf(error) else text_with_unit(Cell(error, unit), DIGITS)


def rule_rows(found: StudyView) -> list[tuple[str, str]]:
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


def study_size(found: StudyView) -> list[tuple[str, str]]:
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
        ("conditions", f"{enumeration(counts)} in each cell" if counts else ""),
        ("kinds of conditions", ", ".join(map(str, found.manifest.get("kinds", ())))),
        ("stress", f"{stress} times the nominal uncertainty" if stress else ""),
        ("limits", f"of the first {of_limits} test conditions of each cell" if of_limits else ""),
        ("searches", f"{seeds}, {searches}" if searches else ""),
        ("levels of activity", f"{levels} times that of {found.reference}" if levels else ""),
    ]


def write_study_report(
    table: "pd.DataFrame",
    manifest: Mapping[str, Any],
    verdicts: Verdicts,
    folder: Path,
    *,
    journal: Journal = NO_JOURNAL,
    command: str = "",
) -> Path:
    """Write a study's pictures and its report into its folder.

    The folder then holds ``report.html``, ``verdicts.json``, each picture as PNG and SVG in ``pictures``,
    each table as CSV and LaTeX in ``tables``, for a journal each picture in ``figures``, and ``metrics.json``
    with the SHA-256 of all these. They take their places together, and equal studies give equal bytes.

    Returns:
        The path of ``report.html``.
    """
    found = study_view(manifest, verdicts)
    asked = {key: value for key, value in manifest.items() if key not in VERSIONS}
    fingerprint = hashlib.sha256(
        json.dumps({"manifest": asked, "verdicts": verdicts.as_dict()}, sort_keys=True).encode()
    ).hexdigest()[:12]
    drawn = study_pictures(found)
    again = repeat_commands(table, found, conditions_in(folder))
    levels = {level: law_tables(found._replace(level=level)) for level in verdicts.levels}
    cells = {name: cell_tables(found, name) for name in manifest["cells"] if name in found.at.cells}
    with staged(folder, last=METRICS) as stage:
        for one in drawn:
            figure = one.draw()
            write_figure(figure, stage / PICTURES / one.name, fingerprint)
            journal.save(figure, stage / FIGURES / one.name, fingerprint)
        write_text(stage / VERDICTS, as_json(verdicts.as_dict()) + "\n")
        write_tables(stage, [front_table(found), *chain(*levels.values(), *cells.values())])
        if journal.decimal_comma:
            with_decimal_commas(stage)
        addresses = [(one, data_address(stage / PICTURES / f"{one.name}.svg")) for one in drawn]
        write_text(stage / REPORT, study_page(found, addresses, fingerprint, levels, cells, again, command))
        about = {"title": manifest["title"], "fingerprint": fingerprint, "version": __version__}
        write_metrics(stage, about)
    return folder / REPORT


def study_report_files(folder: Path) -> list[Path]:
    """What :func:`write_study_report` writes beside pictures and tables."""
    return [folder / name for name in (VERDICTS, REPORT, METRICS)]
