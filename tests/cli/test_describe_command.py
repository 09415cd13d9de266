"""`describe` and `schema`."""

import json

import pytest

from hydroservo.scenario.descriptions import scenario_schema
from tests.support.commands.runner import PLUGIN, failed, succeeded


def test_all_types_by_role():
    text = succeeded("describe")
    assert "Cylinder.from_diameters" in text
    assert "PI" in json.loads(succeeded("describe", "--json"))["Controller"]


@pytest.mark.parametrize("name", ["controller", "Controller"])
def test_the_types_of_a_role(name):
    lines = succeeded("describe", name).splitlines()
    assert any(line.split()[:3] == ["PI", "u", "="] for line in lines)
    assert "PI" in json.loads(succeeded("describe", name, "--json"))


def test_a_type_with_its_keys():
    text = succeeded("describe", "PID")
    assert "Astrom" in text
    assert 'a plain number is in this unit; others in quotes, such as "63 mm"' in text
    assert "y: the unit of the controlled signal" in text
    (about,) = json.loads(succeeded("describe", "PID", "--json"))
    assert about["keys"][0] == {
        "name": "proportional_gain",
        "default": "",
        "unit": "V/y",
        "range": "≥ 0",
        "meaning": "proportional gain k_p",
        "source": "",
    }


def test_the_table_that_has_no_types():
    text = succeeded("describe", "simulation")
    assert "integration steps per sample period" in text
    assert "StepResponse" in succeeded("describe", "metrics")


def test_types_of_one_name_are_both_shown():
    text = succeeded("describe", "Sine")
    assert "Sine: Load" in text
    assert "Sine: Reference" in text


def test_a_type_that_is_none():
    assert "did you mean PID?" in failed("describe", "PIDD")
    name = "axis/position"
    assert f"scenario; `hydroservo scenarios show {name}` shows this one" in failed("describe", name)


@pytest.mark.usefixtures("forgotten")
def test_a_type_of_a_plugin(tmp_path):
    (tmp_path / "own.py").write_text(PLUGIN)
    assert "Fixed" in succeeded("describe", "controller", "--plugin", str(tmp_path / "own.py"))
    assert "Fixed" in succeeded("schema", "--plugin", str(tmp_path / "own.py"))


def test_the_schema_on_stdout_and_in_a_file(tmp_path):
    assert json.loads(succeeded("schema")) == scenario_schema()
    place = tmp_path / "new" / "hydroservo.schema.json"
    succeeded("schema", "--out", str(place))
    assert json.loads(place.read_text()) == scenario_schema()
