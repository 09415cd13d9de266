"""hydroservo parts."""

import json

import pytest

import hydroservo as hs
from tests.support.commands.runner import failed, succeeded
from tests.support.reports import check_report

VALVE = "valve/g761-3001b-h04"


def test_the_list_has_names_and_titles_and_its_json_their_sources(tmp_path):
    shown = succeeded("parts")
    assert VALVE in shown
    assert "Moog G761-3001B" in shown
    found = json.loads(succeeded("parts", "--json"))
    assert found.keys() == hs.parts().keys()
    assert "RE 29121" in found["edges/4wrpeh-6-40"]["source"]
    (tmp_path / "mine.toml").write_text('title = "Mine"\ntype = "AeratedOil"\n')
    assert "Mine" in succeeded("parts", "--folder", str(tmp_path))


def test_a_part_is_shown_with_the_source_of_each_number():
    shown = " ".join(succeeded("parts", "show", VALVE).split())
    for text in (
        "frequency_90",
        "200 Hz",
        "p. 9",
        "flow of the open valve under 70 bar",
        "4 L/min",
        "Rev. M",
    ):
        assert text in shown
    found = json.loads(succeeded("parts", "show", VALVE, "--json"))
    assert found["role"] == "Valve"
    assert {"key": "frequency_3db", "value": "120 Hz", "source": "p. 9, as quoted"} in found["numbers"]


def test_what_a_sheet_assumes_is_named():
    shown = " ".join(succeeded("parts", "show", "cylinder/iso-6020-2-63-45").split())
    assert "Assumed for this sheet, not of the part: stroke = 300 mm, mechanism.mass = 100 kg." in shown


@pytest.mark.slow  # it draws
def test_a_picture_and_a_report(tmp_path):
    succeeded("parts", "show", VALVE, "--out", str(tmp_path / "valve.png"))
    assert (tmp_path / "valve.png").stat().st_size > 1000
    succeeded("parts", "show", VALVE, "--out", str(tmp_path / "report"))
    check_report(tmp_path / "report", json.loads(succeeded("parts", "show", VALVE, "--json")))
    text = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert f"hydroservo parts show {VALVE}" in text


def test_a_notebook_shows_the_same():
    shown = hs.part("oil/mil-h-5606")._repr_html_()
    assert "bulk modulus at 100 bar" in shown
    assert "The Lee Company" in shown


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("show", "valve/g761"), "is not a built-in part, and there is no such file"),
        (("show",), "missing argument 'NAME'"),
        ((VALVE,), f"hydroservo parts show {VALVE} prints what has that name"),
    ],
)
def test_refusals_are_one_line(words, said):
    assert said in failed("parts", *words)
