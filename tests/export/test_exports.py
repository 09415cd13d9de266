"""What scenarios export, through the tools of its users."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from benchmarks.targets.boards import BOARDS, COMPILER, Board, compiled
from benchmarks.targets.host import library
from benchmarks.targets.sources import Rows, width
from benchmarks.targets.symbols import foreign, undefined
from cppcheck import findings, unaccepted
from fuzz import BLOCK, fuzzed, verdict
from needs import needs
from sanitizers import watched

from hydroservo.export.exported import Exported
from hydroservo.export.units import Part, Precision, exported
from hydroservo.scenario import load_scenario

COMPILERS = ("gcc", "clang")
SLOW_ALONE = {"copysign", "copysignf"}  # that gcc calls where it does not optimise at all; exact everywhere


class Case(NamedTuple):
    """What is exported."""

    scenario: str
    part: Part = Part.CONTROLLER
    precision: Precision = Precision.DOUBLE
    inlined: bool = False


CASES = (
    Case("paper/sine-pi"),
    Case("paper/sine-backstepping"),
    Case("paper/sine-tsmc"),
    Case("paper/sine-tsmc", precision=Precision.SINGLE),
    Case("paper/sine-tsmc", inlined=True),
    Case("paper/sine-tsmc", Part.LOOP),
    Case("rig/noisy-1khz-tsmc-sine"),
    Case("rig/noisy-1khz-tsmc-sine", Part.MACHINE),
    Case("rig/excavator-link"),
    Case("rig/excavator-link", precision=Precision.SINGLE),
    Case("rig/excavator-link", Part.MACHINE),
    Case("rig/excavator-link", Part.LOOP, inlined=True),
)
CONTROLLERS = [case for case in CASES if case.part is Part.CONTROLLER]


def named(case: Case) -> str:
    return f"{case.scenario}-{case.part}-{case.precision}{'-inlined' if case.inlined else ''}"


each_case = pytest.mark.parametrize("case", CASES, ids=named)
each_controller = pytest.mark.parametrize("case", CONTROLLERS, ids=named)


@cache
def unit_of(case: Case) -> Exported:
    loop = load_scenario(case.scenario)
    return exported(
        loop, case.part, prefix="unit", title=case.scenario, precision=case.precision, inlined=case.inlined
    )


def rows_of(unit: Exported, count: int = 1000) -> Rows:
    """Ordinary numbers, as small as velocities are."""
    return np.random.default_rng(0).normal(0.0, 0.02, (count, width(unit)))


@each_case
def test_compilers_agree_and_call_nothing_but_roots(case: Case, tmp_path: Path) -> None:
    needs(*COMPILERS, "nm")
    unit, bits = unit_of(case), set()
    for compiler in COMPILERS:
        for level in ("-O0", "-O2", "-O3"):
            bits.add(library(unit, tmp_path, compiler, [level]).run(rows_of(unit, 200)).tobytes())
            known = SLOW_ALONE if level == "-O0" else set()
            assert foreign(undefined(tmp_path / "unit.o")) <= known, f"{compiler} {level}"
    assert len(bits) == 1


@each_case
def test_cppcheck_finds_nothing_but_accepted_deviations(case: Case, tmp_path: Path) -> None:
    needs("cppcheck")
    assert unaccepted(findings(unit_of(case), tmp_path)) == []


@each_case
@pytest.mark.parametrize("board", BOARDS, ids=[board.name for board in BOARDS])
def test_boards_call_nothing_but_roots_and_helpers(case: Case, board: Board, tmp_path: Path) -> None:
    needs(COMPILER)
    assert foreign(undefined(compiled(unit_of(case), board, tmp_path), "arm-none-eabi-nm")) == set()


@pytest.mark.parametrize("compiler", COMPILERS)
@each_case
def test_nothing_undefined_with_any_input(case: Case, compiler: str, tmp_path: Path) -> None:
    needs(compiler)
    unit = unit_of(case)
    program = watched(unit, tmp_path, compiler)
    program.run(rows_of(unit))
    for seed in range(3):
        program.run(fuzzed(rows_of(unit), seed), restart=BLOCK)


@pytest.mark.parametrize("seed", range(3))
@each_controller
def test_a_controller_commands_within_its_limits_and_recovers(case: Case, seed: int, tmp_path: Path) -> None:
    needs("gcc")
    unit = unit_of(case)
    limit = max(signal.value for signal in unit.parameters if signal.path.endswith(".limit"))
    found = verdict(library(unit, tmp_path), rows_of(unit, 100 * BLOCK), limit, seed)
    assert found == (0, 0, 0)
