"""hydroservo parts."""

import json

import pytest

import hydroservo as hs
from tests.support.commands.runner import failed, succeeded
from tests.support.reports import check_report

EDGES = "edges/4wrpeh-6-40"


def test_the_list_has_names_and_titles_and_its_json_their_sources(tmp_path):
    shown = succeeded("parts")
    assert EDGES in shown
    assert "4WRPEH 6" in shown
    found = json.loads(succeeded("parts", "--json"))
    assert found.keys() == hs.parts().keys()
    assert "RE 29121" in found["edges/4wrpeh-6-40"]["source"]
    (tmp_path / "mine.toml").write_text('title = "Mine"\ntype = "AeratedOil"\n')
    assert "Mine" in succeeded("parts", "--folder", str(tmp_path))


def test_a_part_is_shown_with_the_source_of_each_number():
    shown = " ".join(succeeded("parts", "show", EDGES).split())
    for text in ("rated_flow", "40 L/min", "35 bar at each control edge", "RE 29121"):
        assert text in shown
    found = json.loads(succeeded("parts", "show", EDGES, "--json"))
    assert found["role"] == "MeteringEdges"
    sources = {one["key"]: one["source"] for one in found["numbers"]}
    assert "p. 2" in sources["rated_drop"]


def test_what_a_sheet_assumes_is_named():
    shown = " ".join(succeeded("parts", "show", "cylinder/iso-6020-2-63-45").split())
    assert "Assumed for this sheet, not of the part: stroke = 300 mm, mechanism.mass = 100 kg." in shown


@pytest.mark.slow  # it draws
def test_a_picture_and_a_report(tmp_path):
    succeeded("parts", "show", EDGES, "--out", str(tmp_path / "edges.png"))
    assert (tmp_path / "edges.png").stat().st_size > 1000
    succeeded("parts", "show", EDGES, "--out", str(tmp_path / "report"))
    check_report(tmp_path / "report", json.loads(succeeded("parts", "show", EDGES, "--json")))
    text = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert f"hydroservo parts show {EDGES}" in text


def test_a_notebook_shows_the_same():
    shown = hs.part("oil/mil-h-5606")._repr_html_()
    assert "bulk modulus at 100 bar" in shown
    assert "The Lee Company" in shown


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("show", "edges/4wrpeh"), "is not a built-in part, and there is no such file"),
        (("show",), "missing argument 'NAME'"),
        ((EDGES,), f"hydroservo parts show {EDGES} prints what has that name"),
    ],
)
def test_refusals_are_one_line(words, said):
    assert said in failed("parts", *words)
