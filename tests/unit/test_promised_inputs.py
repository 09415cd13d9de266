"""That the counting of inputs sees what is accepted and should not be, what it found, and a short count."""

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hydroservo.core.errors import HydroservoError
from hydroservo.scenario import load_scenario
from tools.promises import inputs
from tools.promises.given import Given, load
from tools.promises.inputs import judged
from tools.promises.logs import read
from tools.promises.results import run_plugin

ROOT = Path(__file__).parents[2]
CORPUS = ROOT / "tests" / "support" / "inputs"
USES: dict[str, Callable[[Path], Any]] = {".toml": load_scenario, ".py": run_plugin}


@pytest.mark.parametrize("name", sorted(path.name for path in CORPUS.iterdir()))
def test_what_was_found_is_mended(name: str, tmp_path: Path) -> None:
    """Each file once led to a traceback, a crash or silence."""
    shutil.copy(CORPUS / name, tmp_path)
    use = USES.get(Path(name).suffix, read)
    found = judged(Given(name, {}, lambda folder: use(folder / name)), tmp_path)
    assert found == (name.startswith("refused-"), "", "")


@pytest.mark.parametrize("value", [{}, [], np.array([1.0, 2.0])], ids=["table", "list", "array"])
def test_what_is_no_number_in_place_of_one_is_refused(value: object) -> None:
    with pytest.raises(HydroservoError, match=r"plant\.mass: .+ must be a finite number"):
        load_scenario("paper/sine-pi", {"plant.mass": value})


def raises(_folder: Path) -> None:
    raise KeyError("no")


def says_two_lines(_folder: Path) -> None:
    error = HydroservoError("a")
    error.args = ("a\nb",)
    raise error


def takes_for_ever(_folder: Path) -> None:
    while True:
        pass


@pytest.mark.parametrize(
    ("use", "wrong", "fault"),
    [
        (raises, "", "KeyError: 'no'"),
        (says_two_lines, "", "more than a line"),
        (takes_for_ever, "", "took more than"),
        (lambda _: None, "out of range", "accepted out of range"),
        (lambda _: load_scenario("paper/sine-pi"), "", ""),
    ],
)
def test_what_may_not_be_is_seen(
    use: Callable[[Path], Any], wrong: str, fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(inputs, "PATIENCE", 0.1)
    assert judged(Given("", {}, use, wrong), tmp_path).fault[: len(fault) or None] == fault


def test_another_loop_from_its_text_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inputs, "again", lambda *_: load_scenario("paper/sine-pi", {"plant.mass": "7 kg"}))
    one = Given("", {"a.toml": b'base = "paper/sine-pi"'}, load)
    assert judged(one, tmp_path).fault == "its canonical text is another loop"


COUNT = """
from tools.promises.inputs import count_inputs
print(sum(row["attempts"] for row in count_inputs(300, 7, lambda _: None) if not row["broken"]))
"""


@pytest.mark.nightly  # it loads all that ships first
def test_a_short_count_finds_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", COUNT], cwd=ROOT, text=True, capture_output=True, check=True)
    assert done.stdout.split() == ["300"]
