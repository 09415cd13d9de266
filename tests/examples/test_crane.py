"""What the page on a crane from a public record says of its machine."""

import re
import shutil
import sys
from importlib import import_module
from pathlib import Path

import pytest

import hydroservo as hs
from hydroservo.core.block import leaves

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "crane.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def crane():
    sys.path.insert(0, str(ROOT / "scripts"))
    yield import_module("crane")
    sys.path.remove(str(ROOT / "scripts"))


@pytest.fixture(scope="module")
def shipped(crane):
    return hs.load_scenario(crane.SCENARIO)


def test_the_licence_is_there():
    text = (ROOT / "examples" / "crane" / "LICENSE.crane").read_text(encoding="utf-8")
    assert "Zhenwen Dai" in text
    assert "Redistributions of source code must retain" in text


def test_the_free_run_misses_no_more_than_the_page_says(crane, shipped):
    measured = crane.record().pressure
    first, second = crane.errors(crane.free_run(shipped).pressure, measured)
    most = float(re.search(r"by less than (0\.\d+) rms in the second half", PAGE)[1])
    assert first < second < most
    assert most < 0.5 * crane.errors(crane.linear(), measured)[1]


@pytest.mark.slow  # some ten seconds
def test_the_numbers_of_the_scenario_are_those_of_the_fit(crane, shipped, tmp_path):
    shutil.copytree(crane.FOLDER, tmp_path, dirs_exist_ok=True)
    found, own = crane.fitted(tmp_path).parameters, dict(leaves(shipped))
    assert len(found) == 9
    for path in found.keys() & own.keys():
        assert own[path] == pytest.approx(found[path].value, rel=0.02), path
