"""A machine's numbers from a log, and logs that are none."""

import hashlib
import json

import numpy as np
import pandas as pd
import pytest

from hydroservo.scenario import load_scenario
from tests.support.commands.runner import failed, hydroservo_
from tests.support.reports import check_report, text_of
from tests.support.synthetic_logs import RANGES, SCENARIO, SHORT, exact_log, recorded, with_units

pytestmark = pytest.mark.nightly  # tests.regression runs each command

BRIEF = SHORT | {"simulation.duration": "0.3 s", "reference.period": "0.2 s"}
SETTINGS = [f"--set={path}={value!r}" for path, value in BRIEF.items()]
MASS = ("--vary", "plant.mass=-40%..+70%")
EVERY = [word for path, ends in RANGES.items() for word in ("--vary", f"{path}={ends}")]


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "log.csv"
    pd.DataFrame(with_units(recorded(exact_log(BRIEF), 1))).to_csv(path, index=False)
    return path


def test_identify_finds_the_mass_and_writes_what_it_found(log, tmp_path):
    out = tmp_path / "found"
    result = hydroservo_(
        "identify", SCENARIO, log, *EVERY, "--set=plant.mass=8kg", *SETTINGS, "--json", "--out", out
    )
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    mass = said["parameters"]["plant.mass"]
    assert mass["low"] < 6.0 < mass["high"]
    assert mass["identifiable"] is True
    assert "later than of the model" in result.stderr
    check_report(out, said)
    assert {"scenario.toml", "log-1.png", "fit-1.png"} <= {file.name for file in out.iterdir()}
    assert hashlib.sha256(log.read_bytes()).hexdigest() in text_of(out)
    assert load_scenario(out / "scenario.toml").plant.mass == mass["value"]
    check_tables(out / "tables", said)


def check_tables(folder, said):
    """The tables of a report have the numbers that --json prints."""
    parameters, signals = (
        pd.read_csv(folder / f"{name}.csv", index_col=0, dtype=str) for name in ("parameters", "signals-1")
    )
    for path, one in said["parameters"].items():
        *ends, unit = parameters.loc[path, ["value", "from", "to", "unit"]]
        factor = 100.0 if unit == "%" else 1.0
        assert [*map(float, ends)] == [factor * one[end] for end in ("value", "low", "high")]
        assert unit == one["unit"] or (unit == "%" and "%" in RANGES[path])
    for name, one in said["logs"][0]["signals"].items():
        assert [*map(float, signals.loc[name, ["residual, rms", "held out"]])] == [
            one["rms"],
            one["held_out"],
        ]


def damaged(log, tmp_path, **columns):
    """The log with other columns."""
    table = pd.read_csv(log).astype(object)
    for name, change in columns.items():
        (column,) = [one for one in table if one.startswith(name)]
        change(table, column)
    path = tmp_path / "damaged.csv"
    table.to_csv(path, index=False)
    return path


def text_in(table, column):
    table.loc[7, column] = "off"


def without(table, column):
    del table[column]


def in_bar(table, column):
    table[f"{column.split()[0]} [bar]"] = table.pop(column)


def backwards(table, column):
    table.loc[9, column] = 0.0


def constant(table, column):
    table[column] = 1.0


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"command": without}, 'column "command [V]" is missing'),
        ({"velocity": in_bar}, "does not convert to m/s"),
        ({"velocity": text_in}, "line 9, column velocity [m/s]: 'off' must be a finite number"),
        ({"time": backwards}, "line 11, column time [s]"),
        ({"velocity": constant, "hydraulic_force": constant}, "never changes, and nothing else is measured"),
    ],
)
def test_a_wrong_log_is_one_line(log, tmp_path, columns, said):
    assert said in failed("identify", SCENARIO, damaged(log, tmp_path, **columns), *MASS)


def test_a_position_outside_of_the_stroke_is_one_line(log, tmp_path):
    table = pd.read_csv(log)
    table["position [m]"] = 40.0 + table.index / len(table)  # mm, said to be m
    table.to_csv(tmp_path / "log.csv", index=False)
    said = failed("identify", SCENARIO, tmp_path / "log.csv", *MASS)
    assert "position: lies between 40000 mm and" in said
    assert "are its unit and its zero those of the machine?" in said


def test_a_log_shorter_than_a_period_is_one_line(log, tmp_path):
    short = tmp_path / "short.csv"
    pd.read_csv(log).head(20).to_csv(short, index=False)
    said = failed("identify", SCENARIO, short, *MASS, "--set=simulation.period='0.1 s'")
    assert "less than the scenario's sample period" in said


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "must name a number of the machine"),
        (("--vary", "controller.integral_gain=1..2"), "a log takes the place of the controller"),
        (("--vary", "plant.mas=1..2"), "plant.mass"),
        (("--vary", "plant.mass=1..2 bar"), "does not convert to kg"),
        (("--vary", "plant.mass=50..200%"), "'200%' has no sign; write '+50%..+200%' for"),
        ((*MASS, "--vary", "delay=x0.5..x2"), "is relative, and there is no value"),
        ((*MASS, "--set", "identify.columns.speed='v [m/s]'"), "identify.columns.speed"),
        ((*MASS, "--set", "identify.colums.speed='v [m/s]'"), "identify.colums"),
        ((*MASS, "--horizon=20ms"), "applies to predictions; add --form one-step"),
        ((*MASS, "--form=one-step", "--horizon=1ms"), "must be at least two samples, 0.002 s"),
        ((*MASS, "--form=one-step", "--horizon=20mm"), "does not convert to s"),
        ((*MASS, "--form=one-step", "--horizon=0s"), "horizon = 0.0: must be a finite number above 0 [s]"),
        ((*MASS, "--limit", "position=20..80mm"), "add --propose FILE.csv"),
        ((*MASS, "--against", "rig/1khz-no"), "rig/1khz-no"),
        ((*MASS, "--set", "identify.vary.plant.mas='1..2 kg'"), "plant.mas"),
        ((*MASS, "--set", "identify.columns.velocity='v [m/s]'"), "column 'v' for velocity is missing"),
    ],
)
def test_what_cannot_be_sought_is_one_line(log, arguments, said):
    assert said in failed("identify", SCENARIO, log, *arguments)


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        ("speed=1..2", "speed: is not a signal"),
        ("position=80..20mm", "is more than"),
        ("position=1..2bar", "does not convert to m"),
        ("position=-5%..5%", "is relative, and there is no value"),
    ],
)
def test_a_limit_that_is_none_is_one_line(log, tmp_path, limit, said):
    file = tmp_path / "next.csv"
    assert said in failed("identify", SCENARIO, log, *MASS, *SETTINGS, "--propose", file, "--limit", limit)
    assert not file.exists()


def test_what_was_found_is_not_lost_where_no_command_can_be_proposed(log, tmp_path):
    out = tmp_path / "found"
    words = ("--propose", tmp_path / "next.csv", "--limit", "position=0..1um", "--out", out)
    result = hydroservo_("identify", SCENARIO, log, *MASS, *SETTINGS, *words)
    assert result.exit_code != 0
    assert "no command tried stays within the limits" in result.stderr
    assert "plant.mass" in result.stdout
    assert (out / "scenario.toml").exists()


def test_a_command_that_never_changes_is_said(log, tmp_path):
    file = damaged(log, tmp_path, command=constant)
    result = hydroservo_("identify", SCENARIO, file, *MASS, *SETTINGS)
    assert result.exit_code == 3, result.output
    assert "THE MODEL DOES NOT FIT the logs, so they tell none of its numbers." in result.stdout
    written = json.loads(hydroservo_("identify", SCENARIO, file, *MASS, *SETTINGS, "--json").stdout)
    assert written["fits"] is False
    assert written["parameters"]["plant.mass"]["low"] is None
    assert "command never changes: nothing excites the machine" in result.stderr


def test_predictions_a_proposal_and_a_comparison_are_said(log, tmp_path):
    file, smaller = tmp_path / "next.csv", tmp_path / "smaller.toml"
    smaller.write_text(f'base = "{SCENARIO}"\n[identify.vary]\nplant.bulk_modulus = "-20%..+20%"\n', "utf-8")
    asked = ("--vary", "plant.mass=-40%..+70%", "--vary", "valve.time_constant=5..20ms")
    own = ("--set", "identify.vary.plant.bulk_modulus='-20%..+20%'", "--set", "plant.start_position='39 mm'")
    words = ("--form", "one-step", "--propose", file, "--against", smaller)
    limit = ("--limit", "position=10..70mm")
    result = hydroservo_("identify", SCENARIO, log, *asked, *own, *SETTINGS, *words, *limit, "--json")
    assert result.exit_code == 2, result.output  # as many numbers: --vary is of both where both have them
    assert "one must have more" in result.stderr
    smaller.write_text(f'base = "{SCENARIO}"\n', "utf-8")
    result = hydroservo_("identify", SCENARIO, log, *asked, *own, *SETTINGS, *words, *limit, "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert set(said["parameters"]) == {"plant.bulk_modulus", "plant.mass", "valve.time_constant"}
    assert said["horizon"] == 0.05
    assert "intervals know nothing of the bias that noise leaves" in result.stderr
    assert said["comparison"]["numbers"] == 1
    assert said["comparison"]["smaller"] == str(smaller)
    assert set(said["proposal"]["promises"]) == set(said["parameters"])
    assert said["proposal"]["bounds"]["position"] == [0.01, 0.07]
    table = pd.read_csv(file)
    assert list(table) == ["time [s]", "command [V]"]
    assert np.abs(table["command [V]"]).max() <= 10.0
    shown = hydroservo_("identify", SCENARIO, log, *asked, *own, *SETTINGS, *words, *limit)
    assert "its one more number" in " ".join(shown.stdout.split())
    assert "times as narrow" in shown.stdout


def test_a_number_without_influence_and_one_at_an_end_are_said(log):
    ranges = [
        word.replace(RANGES["plant.mass"], "7..9 kg") if "plant.mass" in word else word for word in EVERY
    ]
    result = hydroservo_("identify", SCENARIO, log, *ranges, *SETTINGS, "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)["parameters"]
    assert not found["plant.stroke"]["identifiable"]
    assert found["plant.mass"]["at_end"]
    assert "plant.stroke: has hardly any influence" in result.stderr
    assert "plant.mass: ends at 7.00 kg, an end of its range" in result.stderr
    assert np.isfinite([found["plant.mass"]["low"], found["plant.mass"]["high"]]).all()
