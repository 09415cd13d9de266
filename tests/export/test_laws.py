"""Every law through what the exports of scenarios go through, and how it begins."""

from pathlib import Path

import pytest

from hydroservo import Loop
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part, Precision
from hydroservo.runs.run import runnable_loop
from hydroservo.testing.examples import example
from hydroservo.testing.loops import signal_for
from tests.support.export.cases import limit_of, rows_of
from tests.support.export.cppcheck import findings, unaccepted
from tests.support.export.fuzz import verdict
from tests.support.export.sanitizers import watched
from tests.support.needs import needs
from tools.targets.laws import LAWS

pytestmark = pytest.mark.slow


def unit_of(name: str, precision: Precision) -> CModule:
    """What is exported of a law."""
    loop = example(Loop, controller=LAWS[name], controls=signal_for(LAWS[name]))
    return exported_unit(loop, Part.CONTROLLER, prefix="unit", title=name, precision=precision)


@pytest.mark.nightly
@pytest.mark.parametrize("name", LAWS)
def test_cppcheck_finds_in_no_law_what_it_does_not_in_scenarios(name: str, tmp_path: Path) -> None:
    needs("cppcheck")
    assert unaccepted(findings(unit_of(name, Precision.DOUBLE), tmp_path)) == []


@pytest.mark.nightly
@pytest.mark.parametrize("name", LAWS)
def test_each_law_keeps_to_the_standard_while_it_is_watched(name: str, tmp_path: Path) -> None:
    needs("clang")
    unit = unit_of(name, Precision.SINGLE)
    assert verdict(watched(unit, tmp_path, "clang"), rows_of(unit), limit_of(unit)) == (0, 0, 0)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_begins_at_0_volts(name: str) -> None:
    loop = example(Loop, controller=LAWS[name], controls=signal_for(LAWS[name]))
    assert runnable_loop(loop).controller.init().u == 0.0
