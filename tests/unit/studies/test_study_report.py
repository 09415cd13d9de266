"""The report on a study: one page that says what the verdicts say, the same bytes for the same study."""

import csv
import html
import json
import re
import shlex

import numpy as np
import pytest

from hydroservo.core.formatting import brief
from hydroservo.show.files import foreign_files
from hydroservo.show.html import html_of
from hydroservo.show.journal import Journal, decimal_commas
from hydroservo.show.table import texts_of
from hydroservo.show.terminal import show_finding
from hydroservo.studies.fronts import choose_gains
from hydroservo.studies.law_pairs import ErrorRatio
from hydroservo.studies.report.finding import study_finding
from hydroservo.studies.report.folder import conditions_in, repeat_commands, write_study_report
from hydroservo.studies.report.pictures import study_pictures
from hydroservo.studies.report.sentences import lead_sentence, sentences
from hydroservo.studies.report.tables import cell_tables, front_table, law_tables
from hydroservo.studies.report.view import grid_of, study_view
from hydroservo.studies.study import StudyResult
from hydroservo.studies.trials import GAINS, Rules, judged_columns
from hydroservo.studies.verdicts import study_verdicts
from tests.support.study_data import (
    made_up_limits,
    made_up_manifest,
    made_up_table,
    part_of,
    write_conditions,
)

LAWS = [
    "ADRC+ESO",
    "ADRC+Kalman",
    "PI+ESO",
    "PI+Kalman",
    "TSMC+Kalman",
    "TSMC+Kalman without terminal powers",
]
CELLS = ["fast-high-quick", "fast-low-quick", "slow-high-lagging"]
LEVELS = ["0.5", "1", "2"]
RULES = Rules(resamples=100)


@pytest.fixture(scope="module")
def study():
    """Manifest, table and verdicts of a small study."""
    manifest = part_of(made_up_manifest(), LAWS, CELLS)
    table = made_up_table(manifest)
    return manifest, table, study_verdicts(table, manifest, RULES, made_up_limits(table))


@pytest.fixture(scope="module")
def folder(study, tmp_path_factory):
    manifest, table, verdicts = study
    out = tmp_path_factory.mktemp("report")
    write_conditions(manifest, out)
    write_study_report(table, manifest, verdicts, out)
    return out


@pytest.fixture(scope="module")
def page(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def text_of(page):
    page = re.sub(r"<style>.*?</style>|<[^>]*>", " ", page, flags=re.DOTALL)
    return " ".join(html.unescape(page).split())


def test_the_folder_holds_the_page_and_each_picture(folder, study):
    names = [one.name for one in study_pictures(study_view(study[0], study[2]))]
    assert names == ["fronts", "map", "factorial", "parts", "limit"]
    files = [f"pictures/{name}.{ending}" for name in names for ending in ("png", "svg")]
    written = contents(folder)
    tables = ["fronts", *(f"{kind}-{level}" for level in LEVELS for kind in ("laws", "prices"))]
    tables += [f"{kind}-{cell}" for cell in CELLS for kind in ("cell", "limits")]
    files += [f"tables/{name}.{ending}" for name in tables for ending in ("csv", "tex")]
    assert sorted(name for name in written if "conditions" not in name) == sorted(
        ["report.html", "verdicts.json", "metrics.json", *files]
    )
    assert foreign_files(folder) == []
    found = json.loads(written["verdicts.json"])
    assert found["levels"].keys() == set(LEVELS)
    assert all(level["cells"].keys() == set(CELLS) for level in found["levels"].values())


def tables_of(found):
    """The tables of the page."""
    levels = [found._replace(level=level) for level in LEVELS]
    return [
        *(one for level in levels for one in law_tables(level)),
        *(one for cell in CELLS for one in cell_tables(found, cell)),
    ]


def test_tables_have_what_the_page_shows(folder, study, page):
    shown = text_of(page)
    tables = tables_of(study_view(study[0], study[2]))
    assert len(tables) == 2 * (len(LEVELS) + len(CELLS))
    for table in tables:
        texts = texts_of(table)
        assert all(" ".join(row) in shown for row in [texts.headings, *texts.rows])
        with (folder / "tables" / f"{table.name}.csv").open(encoding="utf-8") as file:
            _, *rows = csv.reader(file)
        assert rows == [[exact_text(cell.value) for cell in row] for row in table.rows]


def exact_text(value):
    """A number with all digits; empty where there is none."""
    return value if isinstance(value, str) else "" if np.isnan(value) else repr(value)


def rows_of(table):
    """The numbers of a table, by law and heading."""
    names = [column.heading for column in table.columns]
    return {row[0].value: dict(zip(names, (cell.value for cell in row), strict=True)) for row in table.rows}


def test_cells_of_tables_are_the_numbers_of_verdicts(study):
    manifest, _, verdicts = study
    found = study_view(manifest, verdicts)
    laws, _ = law_tables(found)
    for law, row in rows_of(laws).items():
        ratio = found.to_reference(law)
        if np.isfinite(ratio.value):
            assert (row["error"], row["error low"], row["error high"]) == ratio
        else:
            assert np.isnan([row["error"], row["error low"], row["error high"]]).all()
    for name, cell in verdicts.levels["1"].cells.items():
        own, limits = map(rows_of, cell_tables(found, name))
        assert own.keys() == limits.keys() == set(LAWS)
        for law, one in cell.standings.items():
            row = own[law]
            assert (row["error"], row["error low"], row["error high"]) == one[:3]
            assert (row["tail"], row["activity"]) == (one.tail, one.activity)
            assert row["lost runs high"] == 100.0 * one.lost.high
            assert limits[law]["runs"] == cell.limit.laws[law].runs
    fronts = front_table(found)
    points = [one for own in verdicts.fronts.values() for law in own.values() for one in law.points]
    assert [row[4].value for row in fronts.rows] == [one.error for one in points]


def test_a_table_has_one_unit_for_its_errors(study):
    manifest, _, verdicts = study
    found = study_view({**manifest, "unit": "N"}, verdicts)
    far = found._replace(verdicts=with_errors(verdicts, 1e7))
    for view, unit in ((found, "[N]"), (far, "[kN]")):
        headings = texts_of(cell_tables(view, CELLS[0])[0]).headings
        assert sum(one.endswith(unit) for one in headings) == 4
    (table, *_) = study_finding(StudyResult(None, manifest, [], None, verdicts)).tables
    assert {row[-2] for row in texts_of(table).rows} == {"mm/s"}


def with_errors(verdicts, factor):
    """The verdicts, with all errors of cells that many times as large, and the lower ends small."""
    cells = {
        name: cell._replace(
            standings={
                law: one._replace(error=factor * one.error, tail=factor * one.tail)
                for law, one in cell.standings.items()
            }
        )
        for name, cell in verdicts.levels["1"].cells.items()
    }
    return with_cells(verdicts, **cells)


def test_the_best_law_and_its_ties_are_marked(study):
    manifest, _, verdicts = study
    found = study_view(manifest, verdicts)
    for name, cell in verdicts.levels["1"].cells.items():
        marks = {row[0].value: {one.mark for one in row} for row in cell_tables(found, name)[0].rows}
        assert {law for law, mark in marks.items() if mark == {"best"}} == set(filter(None, [cell.best.law]))
        assert {law for law, mark in marks.items() if mark == {"good"}} == set(cell.best.ties) - {
            cell.best.law
        }


def test_a_study_says_the_error_of_each_law_at_each_level(study, folder, capsys):
    manifest, table, verdicts = study
    finding = study_finding(StudyResult(folder, manifest, table, None, verdicts))
    assert finding.numbers == {"title": manifest["title"], **verdicts.as_dict()}
    assert [one.name for one in finding.tables] == [f"activity-{cell}" for cell in CELLS]
    for cell, one in zip(CELLS, finding.tables, strict=True):
        assert [row[0].value for row in one.rows] == sorted(
            LAWS,
            key=lambda law, cell=cell: min(
                level.cells[cell].standings[law].error for level in verdicts.levels.values()
            ),
        )
        for law, *errors, _, lost in one.rows:
            standings = [level.cells[cell].standings[law.value] for level in verdicts.levels.values()]
            assert [error.value for error in errors] == [each.error for each in standings]
            assert lost.value == 100.0 * max(each.lost.value for each in standings)
            ties = [law.value in level.cells[cell].best.ties for level in verdicts.levels.values()]
            assert [error.mark == "best" for error in errors] == ties
    assert finding.lead[0].lead == lead_sentence(study_view(manifest, verdicts))
    show_finding(finding)
    shown = capsys.readouterr().out
    page = html.unescape(html_of(finding))
    for text in (manifest["title"], *LAWS, "mm/s", "lost runs at most [%]"):
        assert text in shown
        assert text in page


def test_the_page_needs_no_other_file(page):
    addresses = re.findall(r"""(?:src|href|srcset|data|action)\s*=\s*["']([^"']*)""", page)
    assert all(one.startswith(("data:image/svg+xml;base64,", "#")) for one in addresses)
    assert not re.search(r"<script|<link|@import|url\(|https?:", page.split("base64,")[0])
    anchors = set(re.findall(r'id="([^"]*)"', page))
    assert {one[1:] for one in addresses if one.startswith("#")} <= anchors


def test_the_page_is_well_formed(page):
    for tag in ("table", "tr", "td", "th", "figure", "div", "code", "ul", "li", "h3", "p"):
        assert len(re.findall(rf"<{tag}[ >]", page)) == page.count(f"</{tag}>"), tag
    assert "{{" not in page
    assert "prefers-color-scheme: dark" in page
    assert "@media print" in page


@pytest.mark.slow
def test_equal_studies_give_equal_bytes(study, folder, tmp_path):
    manifest, table, _ = study
    shuffled = table.sample(frac=1.0, random_state=5)
    write_conditions(manifest, tmp_path)
    verdicts = study_verdicts(shuffled, manifest, RULES, made_up_limits(shuffled))
    write_study_report(shuffled, manifest, verdicts, tmp_path)
    assert contents(tmp_path) == contents(folder)


def with_cells(verdicts, **cells):
    """The verdicts, but for some cells at the reference's own activity."""
    own = verdicts.levels["1"]
    return verdicts._replace(levels={**verdicts.levels, "1": own._replace(cells={**own.cells, **cells})})


def with_best(verdicts, **bests):
    """The verdicts, but for who wins each cell at the reference's own activity."""
    cells = {
        name: cell._replace(best=cell.best._replace(**bests[name]))
        for name, cell in verdicts.levels["1"].cells.items()
    }
    return with_cells(verdicts, **cells)


def test_the_lead_counts_which_law_is_best_and_how_surely(study):
    manifest, _, verdicts = study
    won = {"state": "won", "law": "PI+ESO", "ties": ["PI+ESO"]}
    tie = {"state": "tie", "law": "PI+ESO", "ties": ["PI+ESO", "ADRC+ESO"]}
    none = {"state": "none", "families": [], "law": "", "ties": []}
    found = study_view(manifest, with_best(verdicts, **dict(zip(CELLS, (won, tie, none), strict=True))))
    assert lead_sentence(found) == (
        "At PI+ESO's own activity, PI+ESO is best in 2 of 3 cells (in 1 surely); in 1 every law loses too "
        "many runs."
    )


def test_each_level_has_its_sentence(study):
    manifest, _, verdicts = study
    found = study_view(manifest, verdicts)
    said = [lead_sentence(found), *sentences(found)]
    for text in ("At PI+ESO's own activity, ", "At 0.5 times PI+ESO's", "At 2 times PI+ESO's"):
        assert sum(one.startswith(text) and "is best in" in one for one in said) == 1
    assert any("oscillates for good in some test runs" in one for one in said)
    assert any(re.match("The last half of the candidates moved fronts by", one) for one in said)


def test_who_cannot_be_so_calm_is_said_and_has_no_error(study):
    manifest, table, _ = study
    lively = (table["law"] == "ADRC+ESO") & (table["cell"] == CELLS[0])
    table = table.assign(activity=np.where(lively, 1e3 * table["activity"], table["activity"]))
    verdicts = study_verdicts(table, manifest, RULES)
    assert "ADRC+ESO" not in verdicts.levels["2"].cells[CELLS[0]].standings
    found = study_view(manifest, verdicts)
    assert np.isnan(found.to_reference("ADRC+ESO").value)
    row = rows_of(law_tables(found)[0])["ADRC+ESO"]
    assert row["no gains"] == 1
    assert np.isnan([row["error"], row["error low"], row["error high"]]).all()
    assert any("1 law cannot be compared in every cell" in one for one in sentences(found))
    lost = (table["law"] == "ADRC+ESO") & (table["cell"] == CELLS[0]) & (table["split"] == "test")
    table = study[1].assign(lost=lost | study[1]["lost"], error=study[1]["error"].mask(lost, np.inf))
    found = study_view(manifest, study_verdicts(table, manifest, RULES))
    assert np.isnan(found.to_reference("ADRC+ESO").value)


def test_where_no_law_is_so_calm_is_said(study):
    manifest, _, verdicts = study
    own = verdicts.levels["1"]
    for cells, text in (
        ({}, "no law has so low an activity in any cell"),
        (dict([*own.cells.items()][:1]), "in 2 no law has so low an activity"),
    ):
        levels = {**verdicts.levels, "1": own._replace(cells=cells)}
        view = study_view(manifest, verdicts)._replace(verdicts=verdicts._replace(levels=levels))
        assert text in lead_sentence(view)


def test_an_interval_that_no_verdict_is_by_says_so(study, page):
    """A tie's may leave out 1, for only chances are corrected."""
    for heading in ("over best", "alone low", "alone high"):
        assert page.count(f">{heading}</th>") == len(CELLS)
    assert "the interval that it has alone, not corrected" in text_of(page)
    assert html.unescape(page).count("Holm's chance</th>") == len(CELLS)


def test_the_page_says_each_sentence_and_each_number(study, page):
    manifest, _, verdicts = study
    found = study_view(manifest, verdicts)
    text = text_of(page)
    for sentence in sentences(found):
        assert " ".join(sentence.split()) in text
    for law in LAWS:
        assert np.isnan(found.to_reference(law).value) or interval_text(found.to_reference(law)) in text
    for cell in verdicts.levels["1"].cells.values():
        for one in cell.standings.values():
            assert np.isnan(one.error) or interval_text(1e3 * np.array(one[:3])) in text


def interval_text(numbers):
    """A number and the ends of its interval as columns of the page have them."""
    return " ".join(brief(one, 3) for one in numbers)


def runs_at_own(manifest, table):
    """The test runs at the reference's own activity."""
    runs = judged_columns(table)
    choice = choose_gains(runs, manifest["reference"], [1.0], RULES)
    return runs[runs["split"] == "test"].merge(choice, on=GAINS)


def test_lost_runs_are_said(study):
    manifest, table, verdicts = study
    tests = runs_at_own(manifest, table)
    said = next(one for one in sentences(study_view(manifest, verdicts)) if "test runs were lost" in one)
    assert tests["lost"].sum() > 0
    assert said.startswith(f"{tests['lost'].sum():,} of the {len(tests):,} test runs were lost")


def test_what_a_part_earns_is_said_as_its_interval_has_it(study):
    manifest, _, verdicts = study
    own = verdicts.levels["1"]
    worth = own.worths[LAWS[-1]]
    for ratio, said in (
        ((1.4, 1.3, 1.5), "earns its place"),
        ((1.0, 0.9, 1.1), "earns nothing"),
        ((0.8, 0.7, 0.9), "does harm"),
    ):
        at = own._replace(worths={LAWS[-1]: worth._replace(over_cells=ErrorRatio(*ratio))})
        changed = verdicts._replace(levels={**verdicts.levels, "1": at})
        assert any(
            said in one and "[" in one
            for one in sentences(study_view(manifest, changed))
            if "terminal" in one
        )


def test_the_page_says_how_far_each_law_is_from_the_limits(study, page):
    manifest, _, verdicts = study
    text = text_of(page)
    assert page.count(">over clairvoyant limit</th>") == sum(
        bool(cell.limit.conditions) for cell in verdicts.levels["1"].cells.values()
    )
    for cell in verdicts.levels["1"].cells.values():
        for one in cell.limit.laws.values():
            assert np.isnan(one.clairvoyant) or interval_text(one[:3]) in text
    said = sentences(study_view(manifest, verdicts))
    assert any("the least error of any command that knows the future" in one for one in said)
    assert any(re.match("Of [23] conditions the search for the limit did not end", one) for one in said)
    assert not any("left less than the clairvoyant limit" in one for one in said)


def test_without_limits_nothing_is_said_of_them(study):
    manifest, table, _ = study
    verdicts = study_verdicts(table, manifest, RULES)
    found = study_view(manifest | {"limits": {"conditions": 0}}, verdicts)
    assert not any(one.name.startswith("limits") for cell in CELLS for one in cell_tables(found, cell))
    assert "limit" not in [one.name for one in study_pictures(found)]
    assert not any("limit" in one for one in sentences(found))


def test_a_command_repeats_the_run_in_the_middle(study, folder):
    manifest, table, verdicts = study
    law, cell = LAWS[-1], "fast-low-quick"
    one = repeat_commands(table, study_view(manifest, verdicts), conditions_in(folder))[cell, law]
    words = shlex.split(one.command)
    assert words[:4] == ["hydroservo", "run", "--strict", f"scenarios/{cell}/{law}/sine.toml"]
    sets = dict(word.split("=") for word in words[5::2])
    assert float(sets["truth.plant.mass"]) == 4.0 + one.condition
    own = table[(table["law"] == law) & (table["cell"] == cell) & (table["split"] == "test")]
    assert {
        json.loads(gains)["controller.gain"] for gains in own["parameters"][own["error"] == one.error]
    } == {float(sets["controller.gain"])}
    tests = runs_at_own(manifest, table)
    tests = tests[(tests["law"] == law) & (tests["cell"] == cell)]
    assert one.error == tests["error"].quantile(0.5, interpolation="lower")


def test_the_page_has_a_command_for_each_law_of_each_cell(page):
    assert page.count("<code>hydroservo run ") == len(LAWS) * len(CELLS)
    assert "does not hold the conditions" not in page


def test_axes_come_from_the_cells_where_the_manifest_has_none():
    grid = grid_of(
        {"cells": {"one": {"rate": 1000.0, "load": "none"}, "two": {"rate": 250.0, "load": "none"}}}
    )
    assert [(axis.name, [level.label for level in axis.levels]) for axis in grid.axes] == [
        ("rate", ["1000", "250"]),
        ("load", ["none"]),
    ]
    assert grid_of({"cells": {"only": {}}}).places().keys() == {"only"}


def test_levels_are_shown_in_groups_without_dimension_where_there_are_some():
    axes = [
        {
            "name": "rate",
            "label": "h w",
            "levels": [{"name": "slow", "value": 2.3}, {"name": "fast", "label": "tiny"}],
        }
    ]
    grid = grid_of({"axes": axes, "cells": {"a": {"rate": "fast"}, "b": {"rate": "slow"}}})
    assert [level.label for level in grid.axes[0].levels] == ["2.30", "tiny"]
    assert grid_of({"axes": ["rate"], "cells": {"a": {"rate": "fast"}}}).axes[0].label == "rate"


def test_a_study_of_one_law_in_one_cell_has_a_report(tmp_path):
    manifest = part_of(made_up_manifest(), ["PI+ESO"], ["fast-low-quick"]) | {
        "axes": [],
        "cells": {"fast-low-quick": {}},
    }
    whole = part_of(made_up_manifest(), ["PI+ESO"], ["fast-low-quick"])
    table = made_up_table(whole)
    write_study_report(table, manifest, study_verdicts(table, manifest, RULES), tmp_path)
    text = text_of((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "At PI+ESO's own activity, PI+ESO is best in 1 of 1 cell (in 1 surely)." in text
    assert "This folder does not hold the conditions" in text


def test_tables_have_decimal_commas_where_asked(tmp_path):
    manifest = part_of(made_up_manifest(), LAWS[:3], ["slow-high-lagging"])
    table = made_up_table(manifest)
    for name, journal in (("points", Journal()), ("commas", Journal(decimal_comma=True))):
        write_study_report(
            table, manifest, study_verdicts(table, manifest, RULES), tmp_path / name, journal=journal
        )
    points = {path.name: path.read_text() for path in (tmp_path / "points" / "tables").glob("*.csv")}
    commas = {path.name: path.read_text() for path in (tmp_path / "commas" / "tables").glob("*.csv")}
    assert points
    assert commas == {name: decimal_commas(text) for name, text in points.items()}


def test_a_study_that_nobody_masters_has_a_report(tmp_path):
    manifest = part_of(made_up_manifest(), LAWS[:3], ["slow-high-lagging"])
    table = made_up_table(manifest)
    write_study_report(table, manifest, study_verdicts(table, manifest, RULES), tmp_path)
    assert "every law loses too many runs in every cell" in text_of(
        (tmp_path / "report.html").read_text("utf-8")
    )
