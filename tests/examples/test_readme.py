"""The README's two lines are where CI finds them, and its picture and links are there."""

import re
import shlex
import shutil
import tomllib
from pathlib import Path
from runpy import run_path

import pytest
from typer.testing import CliRunner

import hydroservo as hs
from hydroservo.cli.app import app
from hydroservo.runs import run
from tests.support.commands.runner import SMALL

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "ends_with"), [("paper", "hydroservo paper"), ("test", "pytest")])
def test_line_for_ci(name: str, ends_with: str) -> None:
    found = re.findall(rf"^<!-- ci: {name} -->\n```sh\n(.*)\n```$", README, re.MULTILINE)
    assert len(found) == 1
    assert found[0].startswith("python3 -m venv .venv && ")
    assert found[0].endswith(ends_with)


def test_each_extra_of_a_user_is_named() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    of_developers = {"bench", "test", "docs", "dev"}
    install = README.partition("## Install")[2].partition("\n## ")[0]
    assert set(re.findall(r"^\| `(\w+)` \|", install, re.MULTILINE)) == set(extras) - of_developers


def test_links_lead_somewhere() -> None:
    targets = [target for target in re.findall(r"\]\(([^)]+)\)", README) if "://" not in target]
    assert targets
    assert [target for target in targets if not (ROOT / target.partition("#")[0]).exists()] == []


def test_no_number_is_typed() -> None:
    """Measured numbers belong in what a command makes."""
    made = r"(?:axis|benchmarks|velocity)"
    generated = rf"<!-- {made}: begin -->.*?<!-- {made}: end -->"
    text = re.sub(rf"{generated}|```.*?```|\(https?:[^)]*\)|`[^`]*`", "", README, flags=re.DOTALL)
    text = (
        text.replace("doi:10.1007/s42401-021-00087-w", "")
        .replace("Python 3.11", "")
        .replace("BSD-3-Clause", "")
    )
    assert re.findall(r"\d+", text) == []


def test_the_first_screen_is_an_example() -> None:
    (block,) = re.findall(r"^```toml\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    assert (ROOT / "examples" / "axis.toml").read_text(encoding="utf-8").endswith(f"\n\n{block}")
    first_command = re.findall(r"^```sh\n(hydroservo .*)\n```$", README, re.MULTILINE)[0]
    assert first_command in taste()


@pytest.mark.slow
def test_the_first_table_is_what_its_script_makes() -> None:
    axis = run_path(str(ROOT / "scripts" / "axis"))
    run = hs.simulate(hs.load_scenario(ROOT / "examples" / "axis.toml"), strict=True)
    assert f"{axis['BEGIN']}{axis['table'](run)}{axis['END']}" in README


def test_who_wins_is_what_its_script_makes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    who_wins = run_path(str(ROOT / "scripts" / "who_wins.py"))
    data = who_wins["read"](ROOT / "docs" / "_static" / "velocity.csv")
    assert f"<!-- velocity: begin -->\n{who_wins['overview'](data)}<!-- velocity: end -->" in README


def taste() -> list[str]:
    (block,) = re.findall(r"^<!-- ci: taste -->\n```sh\n(.*?)\n```$", README, re.MULTILINE | re.DOTALL)
    return str(block).splitlines()


def test_the_taste_starts_from_the_install() -> None:
    assert taste()[0] == ". .venv/bin/activate"
    before_fmu = taste()[: next(i for i, line in enumerate(taste()) if "export fmu" in line)]
    assert "pip install '.[fmu]'" in before_fmu


QUICK = ["--set", "simulation.duration=10 ms"]
SHORT = {
    "run": QUICK,
    "compare": QUICK,
    "batch": QUICK,
    "tune": [*QUICK, "--candidates", "2"],
    "study": SMALL,
}


@pytest.mark.slow  # whole commands
@pytest.mark.parametrize("line", [line for line in taste() if line.startswith("hydroservo ")])
def test_a_line_of_the_taste_runs(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For 10 ms, and not compiled."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    plain = run.simulate
    monkeypatch.setattr(run, "simulate", lambda *args, **how: plain(*args, **how | {"compiled": False}))
    _, *words = shlex.split(line)
    done = CliRunner().invoke(app, [*words, *SHORT.get(words[0], [])])
    assert done.exit_code == 0, done.output
