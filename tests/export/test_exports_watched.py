"""What scenarios export, with inputs that are not numbers, or too large, under the sanitizers."""

from pathlib import Path

import pytest

from tests.support.export.cases import COMPILERS, Case, each_case, each_controller, limit_of, rows_of, unit_of
from tests.support.export.fuzz import BLOCK, fuzzed, verdict
from tests.support.export.sanitizers import watched
from tests.support.needs import needs
from tools.targets.host import library

pytestmark = pytest.mark.nightly


@pytest.mark.parametrize("compiler", COMPILERS)
@each_case
def test_nothing_undefined_with_any_input(case: Case, compiler: str, tmp_path: Path) -> None:
    needs(compiler)
    unit = unit_of(case)
    program = watched(unit, tmp_path, compiler)
    program.run(rows_of(unit))
    for seed in range(3):
        program.run(fuzzed(rows_of(unit), seed), restart=BLOCK)


@each_controller
def test_a_controller_commands_within_its_limits_and_recovers(case: Case, tmp_path: Path) -> None:
    needs("gcc")
    unit = unit_of(case)
    built, rows = library(unit, tmp_path), rows_of(unit, 100 * BLOCK)
    for seed in range(3):
        assert verdict(built, rows, limit_of(unit), seed) == (0, 0, 0), seed
