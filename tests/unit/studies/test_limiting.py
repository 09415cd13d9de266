"""The limits of a study: units that no law and no sensor changes, and what has none."""

import sys
from pathlib import Path

import pytest

from hydroservo import HydroservoError, ScenarioError
from hydroservo.studies.cells import LimitedCondition, laws_in_cells, limited_conditions
from hydroservo.studies.spec_file import read_study

FILE = """
base = "rig/noisy-1khz"
laws.pi.scenario = "laws/pi-sine"
laws.lq.scenario = "laws/lq-sine"
conditions = { test = 4, vary."plant.mass" = "-30%..+30%" }
set.simulation.duration = "0.2 s"
set.reference = { type = "Square", amplitude = "30 mm/s", period = "0.2 s" }
limits.conditions = 2
"""
CONVERTER = """
laws.limited.scenario = "laws/pi-sine"
laws.limited.wrapped = { type = "DAC", bits = 12, limit = "5 V" }
"""


def asked(tmp_path: Path, text: str, **changes: object) -> list[LimitedCondition]:
    file = tmp_path / "study.toml"
    file.write_text(text, "utf-8")
    study = read_study(file, {name.replace("__", "."): value for name, value in changes.items()})
    return limited_conditions(study, list(laws_in_cells(study)))


def keys(found: list[LimitedCondition]) -> list[str]:
    return [one.unit.key for one in found]


def test_units_are_of_conditions_and_of_no_law(tmp_path: Path) -> None:
    found = asked(tmp_path, FILE)
    assert [(one.cell, one.condition) for one in found] == [("all", 0), ("all", 1)]
    assert len(set(keys(found))) == 2
    assert keys(asked(tmp_path, FILE.replace('laws.pi.scenario = "laws/pi-sine"', ""))) == keys(found)
    assert keys(asked(tmp_path, FILE + CONVERTER)) == keys(found)
    assert keys(asked(tmp_path, FILE, limits__conditions=3))[:2] == keys(found)
    assert keys(asked(tmp_path, FILE, set__sensors__velocity_noise="5 mm/s")) == keys(found)


@pytest.mark.parametrize(
    "changes",
    [
        {"set__reference__period": "0.1 s"},
        {"set__simulation__substeps": 12},
        {"set__simulation__period": "0.5 ms"},
        {"set__plant__damping": "2000 N s/m"},
        {"conditions__seed": 1},
    ],
)
def test_what_a_limit_depends_on_makes_another_unit(tmp_path: Path, changes: dict[str, object]) -> None:
    assert not set(keys(asked(tmp_path, FILE))) & set(keys(asked(tmp_path, FILE, **changes)))


def test_all_laws_limited_make_another_unit(tmp_path: Path) -> None:
    alone = FILE.replace('laws.pi.scenario = "laws/pi-sine"\nlaws.lq.scenario = "laws/lq-sine"', CONVERTER)
    assert not set(keys(asked(tmp_path, FILE))) & set(keys(asked(tmp_path, alone)))


def test_cells_that_differ_in_sensors_share_their_limits(tmp_path: Path) -> None:
    level = 'axes.noise.levels.{} = {{ set.sensors.velocity_noise = "{} mm/s" }}\n'
    found = asked(tmp_path, FILE + level.format("low", 0.1) + level.format("high", 1))
    assert [one.cell for one in found] == ["low", "low", "high", "high"]
    assert keys(found)[:2] == keys(found)[2:]


def test_without_limits_there_are_no_units(tmp_path: Path) -> None:
    assert asked(tmp_path, FILE, limits__conditions=0) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('metric = "max_error"', "limits: is for the metric rms_error, and this study's is max_error"),
        (
            'set.simulation.integrator.type = "Tsit5"',
            "limits: cannot be sought in all: simulation.integrator = 'Tsit5': chooses its steps",
        ),
        ("set.simulation.period = 1e-9", "limits: cannot be sought in all: simulation.duration = 0.2: has"),
    ],
)
def test_what_has_no_limits_is_said_in_a_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        asked(tmp_path, FILE + text)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_law_whose_commands_limit_is_searched_is_refused(tmp_path: Path) -> None:
    tuned = tmp_path / "tuned.toml"
    law = (
        'base = "laws/pi-sine"\n[controller]\ntype = "DAC"\nbits = 12\nlimit = "5 V"\n'
        '[controller.controller]\ntype = "PI"\nproportional_gain = "1 V s/m"\n[tune]\n'
        'vary."controller.limit" = "1..10 V"\n'
    )
    tuned.write_text(law, "utf-8")
    with pytest.raises(
        ScenarioError, match=r"laws.tuned: searches controller.limit, which limits its command"
    ):
        asked(tmp_path, FILE + 'laws.tuned.scenario = "tuned.toml"')


def test_where_casadi_is_missing_it_is_said_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(HydroservoError, match=r"a limit needs casadi: pip install 'hydroservo\[limit\]'"):
        asked(tmp_path, FILE)
