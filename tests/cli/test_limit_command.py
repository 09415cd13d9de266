"""The limits of a scenario, and what has none."""

import json

import pandas as pd
import pytest

from tests.support.commands.runner import failed, succeeded
from tests.support.reports import check_report

SHORTER = ("--set", "simulation.duration=0.06", "--set", "reference.period=0.06")  # s; a jump at half of it
SQUARE = ("limit", "rig/1khz-pi-square", *SHORTER)


def test_limit_prints_what_each_command_leaves():
    lines = succeeded(*SQUARE).splitlines()
    rows = {cells[1].strip(): cells for line in lines if len(cells := line.split("│")) > 3}
    assert list(rows) == ["law", "causal", "clairvoyant"]
    assert all(cells[2].strip().endswith("mm/s") for cells in rows.values())
    assert rows["causal"][3].strip().endswith("times this")


def test_limit_json_is_one_object(tmp_path):
    out = tmp_path / "out"
    said = json.loads(succeeded(*SQUARE, "--json", "--out", out))
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
