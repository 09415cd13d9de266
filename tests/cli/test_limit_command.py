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
