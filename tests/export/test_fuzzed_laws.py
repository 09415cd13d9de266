"""Many random laws: each is refused, or does in C what it does in Python, bit for bit."""

from pathlib import Path

import pytest

from tests.support.export.law_campaign import SANITIZED, Tried, campaign, tried, wrong
from tests.support.needs import needs

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.txt"))  # laws that were wrong once


each_build = pytest.mark.parametrize(
    "flags",
    [
        pytest.param(("-O2",), id="optimized"),
        pytest.param(SANITIZED, id="sanitized", marks=pytest.mark.nightly),
    ],
)


@pytest.mark.slow  # compiles each law
@each_build
def test_random_laws_agree_or_are_refused(flags: tuple[str, ...], tmp_path: Path) -> None:
    needs("gcc")
    counts, found = campaign(0 if flags == SANITIZED else 1000, 50, tmp_path, flags)
    assert found == []
    assert counts["agreed"] >= 10


@each_build
def test_laws_that_were_wrong_once_are_no_more(flags: tuple[str, ...], tmp_path: Path) -> None:
    needs("gcc")
    found = [tried(one.stem, one.read_text(encoding="utf-8"), tmp_path) for one in CORPUS]
    assert {one for one in found if isinstance(one, str)} <= {"refused"}
    assert wrong([one for one in found if isinstance(one, Tried)], tmp_path, flags) == []
