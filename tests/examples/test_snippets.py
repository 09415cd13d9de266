"""What the README and the documentation show and the documentation's build does not execute."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hydroservo.cli.commands import app

pytestmark = pytest.mark.nightly  # as the cells of the pages are

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").rglob("*.md"))
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
# The README's own lines have tests of their own, and so has the page; what takes minutes is run by .ci/run.
ELSEWHERE = ("python3 -m venv", "pip install", "pipx", "uvx", "hydroservo paper", "hydroservo app")


def blocks(language: str) -> list[str]:
    texts = (page.read_text(encoding="utf-8") for page in PAGES if "_build" not in page.parts)
    return [body for text in texts for found, body in BLOCK.findall(text) if found == language]


def shell_lines() -> list[str]:
    lines = (line for body in blocks("sh") for line in body.splitlines() if line)
    return [line for line in lines if not line.startswith(ELSEWHERE)]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(ROOT / "examples", tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


@pytest.mark.parametrize("line", shell_lines())
def test_command_lines(line: str, folder: Path) -> None:
    program, *arguments = shlex.split(line)
    assert program == "hydroservo"
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("text", blocks("python"))
def test_python(text: str, folder: Path) -> None:
    exec(compile(text, "snippet", "exec"), {"__name__": "snippet"})
