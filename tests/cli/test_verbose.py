"""What --verbose says of kernels."""

import os
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from hydroservo.cli.commands import app
from hydroservo.engine import native

PLUGIN = """
from typing import NamedTuple

import numpy as np


class RootState(NamedTuple):
    u: float


class Root(NamedTuple):
    def init(self):
        return RootState(0.0)

    def step(self, s, y, r, dt):
        return RootState(np.sqrt(r.value * r.value))
"""
QUICK = ("run", "paper/sine-pi", "--set", "simulation.duration=1ms", "--json")


COMPILED = r"compiled in \d+\.\d s; kept on disk"


def said_of(kernel: str, what: str) -> str:
    """The line on a kernel, as a pattern."""
    return f"hydroservo: kernel '{kernel}' {what}\n"


def ran(*arguments: str) -> Any:
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    return result


@pytest.fixture(autouse=True)
def _no_kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, forgotten: None) -> None:
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(native, "READY", {})


def test_a_kernel_is_said_to_be_compiled_and_then_read(monkeypatch: pytest.MonkeyPatch) -> None:
    first = ran(*QUICK, "--verbose").stderr
    assert re.fullmatch(said_of("run", COMPILED) + said_of("rows", COMPILED), first)
    monkeypatch.setattr(native, "READY", {})
    again = ran(*QUICK, "--verbose").stderr
    read = r"read from disk in \d+\.\d\d s"
    assert re.fullmatch(said_of("run", read) + said_of("rows", read), again)
    assert not ran(*QUICK).stderr


@pytest.mark.skipif(os.name != "posix", reason="permissions are those of POSIX")
def test_why_a_kernel_is_not_kept(tmp_path: Path) -> None:
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o777)
    (tmp_path / "root.py").write_text(PLUGIN)
    law = ("--plugin", str(tmp_path / "root.py"), "--set", "controller.type=Root")
    said = ran(*QUICK, *law, "--verbose").stderr
    assert f"; it cannot be kept: Root.step in {tmp_path / 'root.py'} uses np.sqrt, an object of type" in said
    said = ran(*QUICK, "--verbose").stderr
    why = rf"compiled in \d+\.\d s; cache: {tmp_path}/cache is open to other users"
    assert re.fullmatch(said_of("run", why), said)


@pytest.mark.parametrize("command", ["run", "compare", "batch", "tune"])
def test_each_command_that_runs_takes_it(command: str) -> None:
    assert "--verbose" in ran(command, "--help").stdout
