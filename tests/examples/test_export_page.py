"""The page that leads from a scenario to the target, run from top to bottom as its reader would."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import pytest

from tests.support.needs import needs

ROOT = Path(__file__).parents[2]
CELL = re.compile(r"^```\{code-cell\}\n(?::tags:[^\n]*\n)?(.*?)^```", re.MULTILINE | re.DOTALL)


class Reader(ModuleType):
    """What the cells of the page call, with commands that must do what the page says of them."""

    ran: list[str]

    def examples(self) -> None:
        shutil.copytree(ROOT / "examples", ".", dirs_exist_ok=True)

    def terminal(self, *commands: str) -> None:
        for command in commands:
            done = self.done(command)
            assert done.returncode == 0, done.stdout + done.stderr

    def refused(self, command: str) -> None:
        done = self.done(command)
        assert done.returncode == 2
        assert len(done.stderr.strip().splitlines()) == 1
        assert "; use ops." in done.stderr or "apt-get install" in done.stderr

    def table(self, header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        assert rows
        assert all(len(row) == len(header) for row in rows)

    def done(self, command: str) -> "subprocess.CompletedProcess[str]":
        self.ran.append(command)
        return subprocess.run(shlex.split(command), check=False, capture_output=True, text=True)

    def function_in_c(self, file: str, name: str) -> None:
        assert f"{name}(" in Path(file).read_text(encoding="utf-8")

    def records_in_c(self, file: str, *names: str) -> None:
        assert all(f"_{name};" in Path(file).read_text(encoding="utf-8") for name in names)


@pytest.mark.slow
def test_the_page_from_top_to_bottom(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    needs("make", "cc", "fmpy", "hydroservo")
    monkeypatch.chdir(tmp_path)
    reader = Reader("cells")
    reader.ran = []
    monkeypatch.setitem(sys.modules, "cells", reader)
    names: dict[str, object] = {}
    for cell in CELL.findall((ROOT / "docs" / "export.md").read_text(encoding="utf-8")):
        exec(compile(cell, "cell", "exec"), names)
    assert sum(command.startswith("hydroservo export") for command in reader.ran) >= 7
    assert sum(command.startswith("make") for command in reader.ran) >= 3
