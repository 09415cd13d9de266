"""hydroservo check."""

import json
import re
import subprocess
import sys

import pytest

from hydroservo.testing.contract import QUESTIONS
from tests.support import plugins
from tests.support.commands.runner import failed, hydroservo_, succeeded

pytestmark = [pytest.mark.nightly, pytest.mark.usefixtures("forgotten")]

LAW = plugins.LAW.replace(
    "self.gain * (r.value - y.velocity)", "round(self.gain * (r.value - y.velocity), 9)"
)


@pytest.fixture
def few(monkeypatch):
    """The questions that need no compiler."""
    monkeypatch.setattr("hydroservo.testing.contract.QUESTIONS", QUESTIONS[:6])


@pytest.fixture
def mine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "mine.py"
    path.write_text(LAW, encoding="utf-8")
    return path


@pytest.mark.usefixtures("few")
def test_a_good_file(mine):
    shown = succeeded("check", "mine.py")
    assert "Law" in shown
    assert "Controller" in shown
    assert shown.count("ok") == 6
    assert json.loads(succeeded("check", "mine.py", "--json"))["ok"] is True


@pytest.mark.usefixtures("few")
def test_a_bad_file(mine):
    mine.write_text(LAW.replace("0.0)", "0)").replace('"gain k"', '""'), encoding="utf-8")
    result = hydroservo_("check", "mine.py")
    assert result.exit_code == 2
    assert result.stderr == "hydroservo: mine.py: 2 of 6 answers are wrong\n"
    assert "line 16: gain has no meaning" in result.stdout
    assert "line 18: u of init is 0: must be a float" in result.stdout


@pytest.mark.usefixtures("few")
def test_answers_as_json(mine):
    mine.write_text(LAW.replace("0.0)", "0)"), encoding="utf-8")
    result = hydroservo_("check", "mine.py", "--json")
    assert result.exit_code == 2
    found = json.loads(result.stdout)
    assert (found["file"], found["ok"]) == ("mine.py", False)
    assert [one["question"] for one in found["answers"]] == [question.name for question in QUESTIONS[:6]]
    (wrong,) = [one for one in found["answers"] if not one["ok"]]
    assert wrong == {
        "block": "Law",
        "role": "Controller",
        "question": "starts with floats, at rest",
        "ok": False,
        "remark": "u of init is 0: must be a float",
        "line": 18,
    }


def test_what_export_would_refuse_is_said_with_its_line(mine):
    result = hydroservo_("check", "mine.py")
    assert result.exit_code == 2
    assert result.stderr == f"hydroservo: mine.py: 2 of {len(QUESTIONS)} answers are wrong, for 1 cause\n"
    assert "line 22: " in result.stdout
    assert "is not supported; use ops.nearest" in re.sub(r"[\s│]+", " ", result.stdout)


def test_one_cause_is_one_row(mine):
    helper = LAW.replace("@role", "def twice(x):\n    return 2.0 * x\n\n\n@role").replace(
        "round(", "(twice(1.0) * "
    )
    mine.write_text(helper.replace(", 9)", ")"), encoding="utf-8")
    result = hydroservo_("check", "mine.py")
    assert result.stderr == f"hydroservo: mine.py: 2 of {len(QUESTIONS)} answers are wrong, for 1 cause\n"
    assert result.stdout.count("line ") == 1
    assert re.search(r"line \d+: Law.step: twice\(1.0\) is a function of a module; make it", result.stdout)
    mine.write_text(LAW.replace("State(round(", "float(round("), encoding="utf-8")
    result = hydroservo_("check", "mine.py")
    assert (
        result.stderr
        == "hydroservo: mine.py: 1 of 7 answers are wrong; 4 more can be checked once that is fixed\n"
    )


def test_it_leaves_nothing_beside_the_file(mine):
    code = "from hydroservo.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code, "check", "mine.py"], capture_output=True, check=False)
    assert done.returncode == 2
    assert [path.name for path in mine.parent.iterdir()] == ["mine.py"]


@pytest.mark.usefixtures("few")
def test_a_block_without_a_role_is_asked_for_it(mine):
    mine.write_text(LAW.replace("@role(Controller)\n", ""), encoding="utf-8")
    result = hydroservo_("check", "mine.py")
    assert result.exit_code == 2
    assert "say which it is with @role(...)" in " ".join(result.stdout.replace("│", " ").split())


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("x = 1\n", "defines no block: a class with NamedTuple as its base"),
        (
            LAW[: LAW.index("@role")],
            "has no block: no class declares a role, as with @role(Controller), or has the methods of one",
        ),
        (
            LAW.replace("@role(Controller)\n", "").replace("class Law(NamedTuple)", "class Law"),
            "has no block: no class declares a role, as with @role(Controller), or has the methods of one; "
            "not NamedTuples, as blocks are: Law",
        ),
        ("x = 1\ndef f(:\n", "line 2: SyntaxError: invalid syntax"),
        (
            LAW.replace("step(self, s, y, r, dt)", "step(self, s, y)"),
            "line 13: Law says that its role is Controller: its method step must be step(self, s, y, r, dt)",
        ),
    ],
)
def test_a_file_that_cannot_be_asked(mine, text, problem):
    mine.write_text(text, encoding="utf-8")
    assert failed("check", "mine.py") == f"hydroservo: mine.py: {problem}\n"


def test_a_file_that_is_not_there(mine):
    assert failed("check", "none.py") == "hydroservo: none.py: cannot be read: no such file or directory\n"


def test_without_hypothesis(mine, monkeypatch):
    for name in ("behaviour", "drawing"):
        monkeypatch.delitem(sys.modules, f"hydroservo.testing.{name}", raising=False)
        monkeypatch.delattr(f"hydroservo.testing.{name}", raising=False)
    monkeypatch.setitem(sys.modules, "hypothesis", None)
    said = failed("check", "mine.py")
    assert said == "hydroservo: hypothesis is needed here: pip install 'hydroservo[testing]'\n"
