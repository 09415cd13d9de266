"""What scenarios export, through compilers and cppcheck."""

from pathlib import Path

import pytest

from tests.support.export.cases import CASES, COMPILERS, Case, each_case, named, rows_of, unit_of
from tests.support.export.cppcheck import findings, unaccepted
from tests.support.needs import needs
from tests.support.tiers import mostly
from tools.targets.host import library
from tools.targets.symbols import foreign, undefined

pytestmark = pytest.mark.slow  # several compilers for each

SLOW_ALONE = {"copysign", "copysignf"}  # that gcc calls where it does not optimise at all; exact everywhere


@pytest.mark.parametrize("case", mostly(pytest.mark.nightly, CASES, CASES[:2]), ids=named)
def test_compilers_agree_and_call_nothing_but_roots(case: Case, tmp_path: Path) -> None:
    needs(*COMPILERS, "nm")
    unit, bits = unit_of(case), set()
    for compiler in COMPILERS:
        for level in ("-O0", "-O2", "-O3"):
            bits.add(library(unit, tmp_path, compiler, [level]).run(rows_of(unit, 200)).tobytes())
            known = SLOW_ALONE if level == "-O0" else set()
            assert foreign(undefined(tmp_path / "unit.o")) <= known, f"{compiler} {level}"
    assert len(bits) == 1


@pytest.mark.nightly
@each_case
def test_cppcheck_finds_nothing_but_accepted_deviations(case: Case, tmp_path: Path) -> None:
    needs("cppcheck")
    assert unaccepted(findings(unit_of(case), tmp_path)) == []
