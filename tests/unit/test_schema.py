"""The JSON Schema of scenarios, held against every scenario that ships and against what is refused."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field
from hydroservo.scenario import load_plugin
from hydroservo.scenario.descriptions import (
    describe_types,
    keys_of,
    range_text,
    role_named,
    scenario_schema,
    types_by_role,
)
from hydroservo.scenario.other_tables import KEYS
from hydroservo.scenario.scenario_files import builtin_texts
from hydroservo.scenario.tune_table import PARTS
from tests.support.commands.runner import PLUGIN

SCHEMA = scenario_schema()
CHECK = jsonschema.Draft7Validator(SCHEMA)
GOOD = tomllib.loads(builtin_texts()["rig/1khz-tsmc-square"])


def changed(path: str, value: object) -> dict[str, Any]:
    """A scenario with another value at a path."""
    found = copy.deepcopy(GOOD)
    *tables, key = path.split(".")
    table = found
    for name in tables:
        table = table.setdefault(name, {})
    table[key] = value
    return found


def test_it_is_a_schema_and_has_each_table_of_a_scenario() -> None:
    CHECK.check_schema(SCHEMA)
    assert {*Loop._fields, "base", "title", "uncertainty", "truth", "tune", "identify"} == {
        *SCHEMA["properties"]
    }


def test_each_built_in_scenario_is_valid() -> None:
    for name, text in builtin_texts().items():
        assert list(CHECK.iter_errors(tomllib.loads(text))) == [], name


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("plnat", {}),
        ("plant.mas", "7 kg"),
        ("plant.mass", "heavy"),
        ("plant.mass", -1.0),
        ("controller.type", "TSCM"),
        ("controller.observer.gian", 3.0),
        ("simulation.seed", 1.5),
        ("base", 3),
        ("start", "stedy"),
        ("metrics.usual", "yes"),
        ("tune.candidates", "many"),
        ("identify.columns.velocity", 3),
        ("reference", {"type": "Recorded", "series": {"points": [[0.0, 0.0]]}}),
        ("reference", {"type": "Recorded", "series": {"file": "v.csv", "over": "t"}}),
    ],
)
def test_what_a_scenario_may_not_hold_is_marked(path: str, value: object) -> None:
    assert not CHECK.is_valid(changed(path, value))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("plant.mass", "7 kg"),
        ("plant.mass", 7),
        ("start", "steady"),
        ("reference", {"type": "Recorded", "series": {"points": [[0.0, 0.0], ["1 s", "3 mm/s"]]}}),
        (
            "reference",
            {"type": "Recorded", "series": {"file": "v.csv", "period": "1 ms"}},
        ),
        ("start.given", {"plant": {"velocity": "1 mm/s"}}),
        ("metrics.calm", {"type": "Energy"}),
        ("truth.plant.mass", "6 kg"),
        ("identify.columns.velocity", "v [mm/s]"),
        ("identify.vary", {"plant": {"mass": "-40%..+70%"}}),
        ("load", {"type": "Recorded", "series": {"file": "force.csv"}}),
    ],
)
def test_what_a_scenario_may_hold_is_not_marked(path: str, value: object) -> None:
    assert not list(CHECK.iter_errors(changed(path, value)))


@pytest.mark.usefixtures("forgotten")
def test_a_plugin_s_types_are_in_it(tmp_path: Path) -> None:
    law = {"controller": {"type": "Fixed"}}
    assert not CHECK.is_valid(law)
    (tmp_path / "own.py").write_text(PLUGIN)
    load_plugin(tmp_path / "own.py")
    jsonschema.validate(law, scenario_schema())


def test_it_has_the_keys_of_a_search_and_of_logs() -> None:
    tables = SCHEMA["properties"]
    assert {*tables["tune"]["properties"]} == {"vary", "scenarios", *PARTS}
    assert {*tables["identify"]["properties"]} == {*KEYS}


def test_an_editor_shows_meaning_unit_and_range() -> None:
    law = SCHEMA["definitions"]["hydroservo.control.controllers.pi.PI"]["properties"]
    assert law["proportional_gain"]["description"] == "proportional gain k_p [V/y], ≥ 0"
    assert law["integral_gain"]["anyOf"][0] == {"type": "number", "minimum": 0}
    assert law["type"]["description"].startswith("u = sat(k_p e + k_i int e dt)")


@pytest.mark.usefixtures("forgotten")
def test_all_types_of_all_roles_are_described() -> None:
    for names in types_by_role().values():
        for name in names:
            for one in describe_types(name):
                assert one.text
                assert all(key.as_dict()["meaning"] for key in one.keys)


def test_a_table_is_named_as_its_role_is() -> None:
    assert role_named("controller") == role_named("Controller")
    assert "PI" in role_named("controller")
    assert not role_named("simulation")
    assert not role_named("PI")


def test_types_of_one_name_are_all_described() -> None:
    assert [one.roles for one in describe_types("Sine")] == [["Load"], ["Reference"]]


def test_what_has_no_such_name_is_said_with_the_nearest() -> None:
    with pytest.raises(ParameterError, match=r"did you mean Cylinder\.from_diameters\?"):
        describe_types("Cylinder.from_diametrs")


def test_keys_are_those_of_the_declaration() -> None:
    (about,) = describe_types("PI")
    keys = {key.name: key for key in keys_of(next(iter(role_named("controls").values())))}
    assert keys == {}
    assert [key.name for key in about.keys] == [
        "proportional_gain",
        "integral_gain",
        "anti_windup",
        "saturation",
        "controls",
    ]
    assert about.keys[2].shown == "0"
    assert range_text(Field("s", "time", above=0, at_most=2.5)) == "> 0, ≤ 2.5"
