"""hydroservo audit."""

import json
import math

import pytest

from hydroservo.audits import Audit, BlockAssumptions, Chatter
from hydroservo.audits.finding import audit_finding
from hydroservo.core.assumptions import above
from hydroservo.show import Cell
from tests.support import plugins
from tests.support.brink import brink_file
from tests.support.commands.runner import failed, succeeded
from tests.support.reports import check_report, text_of

pytestmark = pytest.mark.slow  # it runs and draws

HELD = above("Lemma 2, D_1", "D_1 is above the largest d_L1", 30.0, 16.7, "m/s^2", measured=True)
SHORT = above("Lemma 2, D_2", "D_2 is above the largest d_L2", 100.0, 1e4, "N/s", measured=True)
UNTOLD = above("excitation", "the demand excites enough", math.nan, math.nan)
SWINGS = Chatter(True, 0.27, 500.0, "the law", 0.0, 0.01, 1.0)
RESTS = Chatter(False, 0.0, math.nan, "nothing", 9.0, 0.01, 1.0)


ASKED = (
    BlockAssumptions("controller", "TSMC", (HELD, SHORT, UNTOLD)),
    BlockAssumptions("controller.observer", "Mine", None),
    BlockAssumptions("controller.derivative", "Exact", ()),
)
AUDIT = Audit(ASKED, False, SWINGS, "")


@pytest.fixture
def found(monkeypatch):
    """What the audit finds, in place of asking."""

    def put(chatter: Chatter | None, reason: str = "", lost: bool = False) -> None:
        monkeypatch.setattr("hydroservo.audits.audit", lambda _: Audit(ASKED, lost, chatter, reason))

    return put


def test_a_table(found):
    found(SWINGS)
    shown = succeeded("audit", "rig/1khz-pi-sine")
    for text in ("holds", "fails", "cannot be told", "0.01", "1.8", "m/s²", "kN/s"):
        assert text in shown
    cells = audit_finding(AUDIT).tables[0].rows
    assert [row[2:4] for row in cells[:2]] == [
        [Cell(30.0, "m/s^2"), Cell(16.7, "m/s^2")],
        [Cell(100.0, "N/s"), Cell(1e4, "N/s")],
    ]
    assert [row[1].value for row in cells[3:]] == ["does not say what it assumes", "assumes nothing here"]
    assert "Chatter is predicted, by the law: 270 mV at 500 Hz, with demand and load as at 1 s." in shown


def test_no_chatter_but_after_a_jolt(found):
    found(RESTS)
    shown = " ".join(succeeded("audit", "rig/1khz-pi-sine").split())
    assert "No chatter is predicted with 10.0 mV of command or more" in shown
    assert "A jolt could leave a swing of 9.00 V." in shown


def test_no_forecast_and_a_run_that_was_lost(found):
    found(None, "plant = 'Cylinder': has no steady state", lost=True)
    shown = succeeded("audit", "rig/1khz-pi-sine")
    assert "No chatter can be predicted: plant = 'Cylinder': has no steady state." in shown
    assert "The run diverged" in shown


def test_json(found, tmp_path):
    found(RESTS)
    said = json.loads(succeeded("audit", "rig/1khz-pi-sine", "--json", "--out", tmp_path))
    check_report(tmp_path, said)
    assert "1 of 3 assumptions holds; 1 cannot be told." in text_of(tmp_path)
    assert (said["scenario"], said["holds"], said["diverged"]) == ("rig/1khz-pi-sine", False, False)
    assert [one["holds"] for one in said["assumptions"]] == [True, False, None]
    assert said["assumptions"][0]["margin"] == pytest.approx(30.0 / 16.7)
    assert said["silent"] == [{"path": "controller.observer", "block": "Mine"}]
    assert said["chatter"]["frequency"] is None


def test_the_oscillation_of_a_press_and_its_causes(tmp_path):
    said = json.loads(succeeded("audit", brink_file(tmp_path, "axis/force"), "--json", "--out", tmp_path))
    assert "without the valve's hysteresis" in text_of(tmp_path)
    assert "No chatter" not in text_of(tmp_path)
    found = said["oscillation"]
    assert (found["unit"], found["frequency"]) == ("N", pytest.approx(35.0, rel=0.1))
    assert found["causes"] == ["integral action", "valve hysteresis"]
    assert {one["cause"]: one["ends"] for one in found["remains"]}["gain"] is False
    assert said["strain"]["supply_pressure"] == pytest.approx(210e5)


def test_a_mistake_is_one_line():
    assert "no-such" in failed("audit", "no-such")


OWN = (
    plugins.LAW
    + """
    def assumptions(self, facts):
        from hydroservo.core.assumptions import sampled_faster

        return [sampled_faster(self.gain, facts, "the gain")]
"""
)


@pytest.mark.usefixtures("forgotten")
def test_a_law_of_ones_own(tmp_path):
    """It runs, is asked, and does not chatter."""
    file = tmp_path / "mine.py"
    file.write_text(OWN, encoding="utf-8")
    said = json.loads(
        succeeded(
            "audit",
            "rig/1khz-pi-sine",
            "--plugin",
            str(file),
            "--set",
            "controller.type=Law",
            "--set",
            "simulation.duration=1s",
            "--json",
        )
    )
    (only,) = said["assumptions"]
    assert (only["block"], only["margin"], only["holds"]) == ("Law", pytest.approx(500.0), True)
    assert said["chatter"]["chatters"] is False
