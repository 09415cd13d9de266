"""The limits of a scenario, and what has none."""

import json

import pandas as pd
import pytest

from tests.support.commands.runner import failed, succeeded
from tests.support.commands.tuning import rows_of
from tests.support.reports import check_report

pytestmark = pytest.mark.slow  # it runs and draws

SHORTER = ("--set", "simulation.duration=0.06", "--set", "reference.period=0.06")  # s; a jump at half of it
SQUARE = ("limit", "rig/1khz-pi-square", *SHORTER)


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """What a search printed as JSON, and the folder that it left."""
    out = tmp_path_factory.mktemp("limit") / "out"
    return json.loads(succeeded(*SQUARE, "--json", "--out", out)), out


def test_limit_prints_what_each_command_leaves(said):
    text = succeeded(*SQUARE)
    rows = {name: cells for name, cells in rows_of(text).items() if len(cells) == 3}
    heading, *names = rows
    assert (heading, names) == ("command", ["law", "causal", "clairvoyant"])
    assert rows[heading][0] == "rms of the velocity error [mm/s]"
    for name in names:
        assert float(rows[name][0]) == pytest.approx(1e3 * said[0]["rms_error"][name], rel=5e-3)
    for name, multiple in said[0]["multiple"].items():
        assert float(rows[name][1]) == pytest.approx(multiple, rel=5e-3)
        assert f"{multiple:.2f} times the {name} limit" in text


def test_limit_json_is_one_object(said):
    said, out = said
    assert list(said) == ["scenario", "hash", "unit", "rms_error", "multiple", "search"]
    errors = said["rms_error"]
    assert errors["clairvoyant"] < errors["causal"] < errors["law"]
    assert said["multiple"]["causal"] == errors["law"] / errors["causal"]
    assert said["search"]["clairvoyant"]["converged"] is True
    law = json.loads(succeeded("run", *SQUARE[1:], "--json"))
    assert errors["law"] == law["metrics"]["rms_error"]
    check_report(out, said)
    assert {"law.csv", "causal.csv", "clairvoyant.csv"} <= {file.name for file in out.iterdir()}
    assert len(pd.read_csv(out / "causal.csv")) == 61


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ("simulation.integrator.type=Tsit5", "chooses its steps; a limit needs equal ones, such as RK4's"),
        ("simulation.period=1 us", "has 3000000 samples, and a search takes up to 200000 with this machine"),
        ("simulation.period=7 us", "must divide the duration"),
        ("reference.typ=Square", "reference.typ"),
    ],
)
def test_what_has_no_limit_is_one_line(changes, said):
    assert said in failed("limit", "rig/1khz-pi-square", "--set", changes)


PERIODS = ("limit", "rig/1khz-pi-square", *SHORTER, "--period", "2 ms, 1ms,7ms,3ms")


@pytest.fixture(scope="module")
def over_periods(tmp_path_factory):
    """What a search at periods of which one does not divide the run printed as JSON, and its folder."""
    out = tmp_path_factory.mktemp("periods") / "out"
    return json.loads(succeeded(*PERIODS, "--json", "--out", out)), out


def test_limits_at_several_periods_are_those_of_each(over_periods, said):
    found, out = over_periods
    assert list(found) == ["scenario", "hash", "unit", "periods"]
    shortest, middle, longest, odd = found["periods"]
    assert [one["period"] for one in found["periods"]] == [1e-3, 2e-3, 3e-3, 7e-3]
    assert shortest["rms_error"] == said[0]["rms_error"]
    assert shortest["multiple"] == said[0]["multiple"]
    for name in ("causal", "clairvoyant"):
        assert shortest["rms_error"][name] < middle["rms_error"][name] < longest["rms_error"][name]
    assert odd["rms_error"] == {"law": None, "causal": None, "clairvoyant": None}
    assert "must divide the duration" in odd["reason"]
    assert not shortest["reason"]
    check_report(out, found)
    assert {"limits.png", "limits.svg"} <= {file.name for file in out.iterdir()}


def test_limits_at_several_periods_print_a_row_each(over_periods):
    text = succeeded(*PERIODS)
    rows = rows_of(text)
    for one in over_periods[0]["periods"]:
        if one["reason"]:
            continue
        law, causal, *_ = map(float, rows[f"{1e3 * one['period']:.0f}"][:2])
        assert law == pytest.approx(1e3 * one["rms_error"]["law"], rel=5e-3)
        assert causal == pytest.approx(1e3 * one["rms_error"]["causal"], rel=5e-3)
    assert "must divide" in text


@pytest.mark.parametrize(
    ("periods", "said"),
    [
        ("0ms", "--period = '0 s': must be above 0"),
        ("-1ms", "--period = '-0.001 s': must be above 0"),
        ("2", "--period = '2 s': must be at most the duration, 0.06 s"),
        ("1ms,1ms", "--period = '0.001 s': is there twice"),
        ("1ms, 7s", "--period = '7 s': must be at most the duration, 0.06 s"),
        ("1ms,,2ms", "--period = '': is not a quantity such as '10 us'"),
        ("1 m", "--period = '1 m': does not convert to s"),
        ("7ms", "must divide the duration"),
    ],
)
def test_a_wrong_period_is_refused_in_one_line(periods, said):
    assert said in failed("limit", "rig/1khz-pi-square", *SHORTER, f"--period={periods}")
