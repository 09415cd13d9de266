"""Forecasts of chatter against runs, and the tables that the documentation shows of them."""

import json
import math
import sys
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

import pytest

from hydroservo import linear, load_scenario, replace
from hydroservo.audits import chatter
from hydroservo.audits.describing import freeze_loop
from tests.support.tiers import mostly
from tools.chatter import LAWS, Case, cases, judged

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def script() -> ModuleType:
    sys.path.insert(0, str(ROOT / "scripts"))
    try:
        loader = SourceFileLoader("chatter_script", str(ROOT / "scripts" / "chatter"))
        module = module_from_spec(spec_from_loader("chatter_script", loader))
        loader.exec_module(module)
    finally:
        sys.path.remove(str(ROOT / "scripts"))
    return module


def test_the_tables_are_of_what_was_found(script: ModuleType) -> None:
    page, rows = script.PAGE.read_text(encoding="utf-8"), script.saved()
    assert len(rows) >= 500
    for text in (script.forecasts(rows), script.audits(rows), script.both(rows), script.single(rows)):
        assert text in page


def test_the_loops_are_those_of_the_script(script: ModuleType) -> None:
    each = len(script.saved()) // len(LAWS)
    assert [one.case for one in script.saved()] == [Case(*json.loads(json.dumps(one))) for one in cases(each)]


@pytest.mark.slow
def test_a_pi_law_swings_at_its_phase_crossover() -> None:
    """A little above its gain margin it does, at the frequency at which that is taken, and not below it."""
    loop = load_scenario("rig/1khz-pi-sine", {"controller.integral_gain": 0.0})
    still = freeze_loop(loop, 1.0)
    point = replace(still.loop, {"controller.proportional_gain": 1.0})
    margins = linear.margins(point, command=still.command)
    limit = margins.gain_margin
    above, below = (
        chatter(replace(loop, {"controller.proportional_gain": factor * limit}), time=1.0)
        for factor in (1.05, 0.95)
    )
    assert not below.chatters
    assert above.chatters
    assert 2.0 * math.pi * above.frequency == pytest.approx(margins.phase_crossovers[0], rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law", mostly(pytest.mark.nightly, ["TSMC, explicit", "super-twisting", "PI"], ["PI"])
)
def test_what_is_foretold_is_what_a_run_shows(law: str) -> None:
    """The first loops of the documentation's table, of which all but one in six are foretold rightly."""
    found = [judged(case) for case in cases(6) if case.law == law]
    kept = [one for one in found if not one.lost]
    assert len(kept) >= 2
    assert sum(one.foretold == one.chatters for one in kept) >= len(kept) - 1
    assert any(one.chatters for one in kept)
