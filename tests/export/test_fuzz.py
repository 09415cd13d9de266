"""Inputs that are not numbers, or too large, do nothing undefined, and what they do is known."""

from pathlib import Path

import numpy as np
import pytest

from hydroservo.export.unit import CModule
from tests.support.export.fuzz import BLOCK, fuzzed, verdict
from tests.support.export.sanitizers import watched
from tests.support.export.toy import toy
from tests.support.export.variants import changed, inputs, single
from tests.support.needs import needs
from tools.targets.compilers import ToolError
from tools.targets.host import program

LIMIT = 10.0  # [V] of the toy
ROWS = 1000


def test_half_of_each_block_is_left_as_it_is() -> None:
    normal = inputs(toy(), ROWS)
    rows = fuzzed(normal, seed=1)
    second = np.arange(ROWS) % BLOCK >= BLOCK // 2
    assert np.array_equal(rows[second], normal[second])
    touched = (rows != normal)[~second]
    assert 0.03 < touched.mean() < 0.07
    assert np.isnan(rows).any()
    assert np.isinf(rows).any()
    assert np.array_equal(rows, fuzzed(normal, seed=1), equal_nan=True)
    assert not np.array_equal(rows, fuzzed(normal, seed=2), equal_nan=True)


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.nightly)])
@pytest.mark.parametrize("unit", [toy(), single()], ids=["double", "single"])
def test_nothing_undefined_and_nothing_beyond_the_limits(
    unit: CModule, compiler: str, tmp_path: Path
) -> None:
    needs(compiler)
    found = verdict(watched(unit, tmp_path, compiler), inputs(unit, ROWS), LIMIT)
    assert found.outside == 0
    assert found.not_numbers > found.lost > 0, "the toy's integral never comes back"


def test_a_command_beyond_the_limits_is_seen(tmp_path: Path) -> None:
    needs("gcc")
    wider = changed(toy(), "u, -self->limit, self->limit", "u, -2.0 * self->limit, 2.0 * self->limit")
    assert verdict(program(wider, tmp_path), inputs(toy(), ROWS), LIMIT).outside > 0


def test_a_law_that_recovers_is_seen_to(tmp_path: Path) -> None:
    needs("gcc")
    forgetful = changed(toy(), "= state->integral + ", "= ")
    found = verdict(program(forgetful, tmp_path), inputs(toy(), ROWS), LIMIT)
    assert found.not_numbers > 0
    assert found.lost == 0


def test_undefined_behaviour_of_such_inputs_alone_stops_the_program(tmp_path: Path) -> None:
    needs("gcc")
    unit = changed(toy(), ".integral = integral,", ".integral = 1e-3 * (double)(long)(1e3 * integral),")
    built = watched(unit, tmp_path, "gcc")
    built.run(inputs(unit, ROWS))
    with pytest.raises(ToolError, match="outside the range"):
        verdict(built, inputs(unit, ROWS), LIMIT)
