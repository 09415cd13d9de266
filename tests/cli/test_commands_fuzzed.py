"""Command lines that make no sense end with one line and the status 2, never with a traceback."""

import subprocess

import pytest

from tests.support.commands.cases import KINDS, case
from tests.support.commands.fuzz import FUZZ, ROOT

CASES = 60


def test_a_number_determines_its_case() -> None:
    assert case(5) == case(5)
    assert {case(number).kind for number in range(300)} == set(KINDS)


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, pytest.param(CASES, marks=pytest.mark.nightly)])
def test_no_command_does_what_none_may(first: int) -> None:
    command = [*FUZZ, "--first", str(first), "--count", str(CASES)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
