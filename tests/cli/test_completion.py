"""What a shell is told to offer."""

import os
import subprocess
from pathlib import Path

import pytest

from hydroservo.cli.options import scenarios_like, studies_like, types_like
from tests.support.commands.processes import HYDROSERVO

pytestmark = pytest.mark.slow  # it runs and draws


def offered(*words):
    """What bash is told for the last of some words."""
    line = {"COMP_WORDS": " ".join(["hydroservo", *words]), "COMP_CWORD": str(len(words))}
    ask = {**os.environ, **line, "_HYDROSERVO_COMPLETE": "complete_bash"}
    return subprocess.run(HYDROSERVO, env=ask, capture_output=True, text=True, check=True).stdout.split()


def test_a_shell_completes_commands_and_scenarios():
    assert offered("lin") == ["linearize"]
    assert offered("run", "rig/1khz-p") == ["rig/1khz-pi-sine", "rig/1khz-pi-square"]


@pytest.mark.parametrize(
    ("like", "begun", "first"),
    [
        (scenarios_like, "axis/c", "axis/crane"),
        (studies_like, "v", "velocity"),
        (types_like, "Cylinder.", "Cylinder.from_diameters"),
        (types_like, "Controlle", "ControlledSignal"),
    ],
)
def test_names_that_begin_so(like, begun, first):
    assert like(begun)[0] == first


def test_files_and_folders_that_begin_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine").mkdir()
    for name in ("mine/a.toml", "mine/b.txt", "mine.toml", "min.csv", "[x].toml"):
        Path(name).touch()
    assert scenarios_like("mi") == ["mine/", "mine.toml"]
    assert scenarios_like("mine/") == ["mine/a.toml"]
    assert scenarios_like("[") == ["[x].toml"]
    assert scenarios_like("no/such") == []
    assert scenarios_like(f"{tmp_path}/mine.") == [f"{tmp_path}/mine.toml"]
