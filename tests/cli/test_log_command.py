import json
from pathlib import Path

import pytest

from tests.support.commands.runner import failed, hydroservo_, succeeded
from tests.support.reports import check_report

pytestmark = pytest.mark.slow  # it runs and draws

ROWS = "".join(f"{0.01 * k:.2f},{4.0 + k % 5:g},{10.0 + k:g},40\n" for k in range(40))
MAPPING = """
base = "axis/position"
[identify.columns]
command = { column = "current", scale = "0.25 V/mA" }
position = { column = "Boom", scale = "7.5 mm/deg" }
"""


@pytest.fixture(autouse=True)
def boom(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("boom.csv").write_text(f"rig 3\n\nTime,Current,Boom,Oil\ns,mA,deg,°C\n{ROWS}", encoding="utf-8")
    Path("boom.toml").write_text(MAPPING, encoding="utf-8")


def test_a_log_is_shown_as_it_is_understood() -> None:
    text = succeeded("log", "boom.csv", "--scenario", "boom.toml", "--out", "boom.png")
    rows = [line.replace("│", " ").split() for line in text.splitlines()]
    assert ["command", "Current", "[mA]", "40", "1", "2", "V"] in rows
    assert ["position", "Boom", "[deg]", "40", "75", "367.5", "mm"] in rows
    assert "A sample every 10 ms (100 Hz), without a gap of more than a few samples" in text
    assert Path("boom.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_as_an_object() -> None:
    result = hydroservo_("log", "boom.csv", "--scenario", "boom.toml", "--json", "--out", "boom/")
    found = json.loads(result.stdout)
    assert found["signals"]["command"]["highest"] == 2.0
    assert found["period"] == pytest.approx(0.01)
    check_report(Path("boom"), found)
    assert "warning: boom.csv: columns that are not used: Oil [°C]" in result.stderr


def test_what_is_not_understood_is_a_line_that_says_what_to_write() -> None:
    line = failed("log", "boom.csv")
    assert "boom.csv: line 3: has no column of anything measured" in line
    assert "measured among Time [s], Current [mA], Boom [deg], Oil [°C]; one must be velocity," in line
    assert "or [identify.columns] says which is which" in line
    assert "must end in one of .png, .svg, .pdf" in failed("log", "boom.csv", "--out", "boom.txt")
