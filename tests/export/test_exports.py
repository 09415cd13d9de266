"""What scenarios export, through the tools of its users."""

from functools import cache
from pathlib import Path
from subprocess import CompletedProcess
from typing import NamedTuple

import numpy as np
import pytest
from benchmarks.targets.boards import BOARDS, COMPILER, Board, compiled, image, ran
from benchmarks.targets.host import library
from benchmarks.targets.laws import LAWS
from benchmarks.targets.sources import Rows, width
from benchmarks.targets.symbols import foreign, undefined
from cppcheck import findings, unaccepted
from fuzz import BLOCK, fuzzed, verdict
from sanitizers import watched

from hydroservo import Loop
from hydroservo.export.exported import Exported, Part, Precision
from hydroservo.export.project import write_c_project
from hydroservo.export.units import exported
from hydroservo.export.vectors import Vectors, made_vectors
from hydroservo.scenario import load_scenario
from needs import needs

COMPILERS = ("gcc", "clang")
EMULATOR = "qemu-system-arm"
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
SINGLE = [case for case in CASES if case.precision is Precision.SINGLE]
CONTROLLERS = [case for case in CASES if case.part is Part.CONTROLLER]


def named(case: Case) -> str:
    return f"{case.scenario}-{case.part}-{case.precision}{'-inlined' if case.inlined else ''}"


each_case = pytest.mark.parametrize("case", CASES, ids=named)
each_board = pytest.mark.parametrize("board", BOARDS, ids=[board.name for board in BOARDS])
each_controller = pytest.mark.parametrize("case", CONTROLLERS, ids=named)


@cache
def unit_of(case: Case) -> Exported:
    loop = load_scenario(case.scenario)
    return exported(
        loop, case.part, prefix="unit", title=case.scenario, precision=case.precision, inlined=case.inlined
    )


@cache
def vectors_of(case: Case) -> Vectors:
    return made_vectors(load_scenario(case.scenario), case.part, unit_of(case))


def rows_of(unit: Exported, count: int = 1000) -> Rows:
    """Ordinary numbers, as small as velocities are."""
    return np.random.default_rng(0).normal(0.0, 0.02, (count, width(unit)))


def limit_of(unit: Exported) -> float:
    """The largest command [V]: of all limits that it goes through the least."""
    return min(signal.value for signal in unit.parameters if signal.path.endswith("saturation.limit"))


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
@each_board
def test_boards_call_nothing_but_roots_and_helpers(case: Case, board: Board, tmp_path: Path) -> None:
    needs(COMPILER)
    assert foreign(undefined(compiled(unit_of(case), board, tmp_path), "arm-none-eabi-nm")) == set()


def replayed(unit: Exported, vectors: Vectors, board: Board, folder: Path) -> CompletedProcess[str]:
    """The replay that is exported beside the code, on a board."""
    write_c_project(unit, vectors, folder)
    sources = [folder / f"{unit.prefix}.c", folder / f"{unit.prefix}_replay.c"]
    return ran(board, image(board, sources, folder))


@each_board
@each_case
def test_boards_pass_the_replay(case: Case, board: Board, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR, "gcc")
    done = replayed(unit_of(case), vectors_of(case), board, tmp_path)
    assert done.returncode == 0, done.stdout
    if case.precision is Precision.DOUBLE:
        count = len(vectors_of(case).expected)
        assert f"{count} of {count} samples bit for bit" in done.stdout


@each_board
def test_a_board_finds_a_wrong_vector(board: Board, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR)
    case = Case("paper/sine-tsmc")
    vectors = vectors_of(case)
    wrong = vectors.expected.copy()
    wrong[40, 3] = np.nextafter(wrong[40, 3], np.inf)
    done = replayed(unit_of(case), vectors._replace(expected=wrong), board, tmp_path)
    assert done.returncode == 1
    assert "sample 41 of" in done.stdout


@each_board
@pytest.mark.parametrize("case", SINGLE, ids=named)
def test_boards_give_the_bits_of_this_machine_in_single_precision(
    case: Case, board: Board, tmp_path: Path
) -> None:
    needs(COMPILER, EMULATOR, "gcc")
    unit, vectors = unit_of(case), vectors_of(case)
    here = library(unit, tmp_path).run(vectors.inputs)
    write_c_project(unit, vectors._replace(expected=here.astype(np.float64)), tmp_path)
    replay = tmp_path / "unit_replay.c"
    replay.write_text(f"#define UNIT_TOLERANCE 0.0\n{replay.read_text()}")
    done = ran(board, image(board, [tmp_path / "unit.c", replay], tmp_path))
    assert done.returncode == 0, done.stdout


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
    found = verdict(library(unit, tmp_path), rows_of(unit, 100 * BLOCK), limit_of(unit), seed)
    assert found == (0, 0, 0)


@pytest.mark.parametrize("precision", Precision)
@pytest.mark.parametrize("name", LAWS)
def test_each_law_passes_what_scenarios_pass(name: str, precision: Precision, tmp_path: Path) -> None:
    needs("cppcheck", "gcc", "clang")
    loop = Loop(controller=LAWS[name])
    unit = exported(loop, Part.CONTROLLER, prefix="unit", title=name, precision=precision)
    assert unaccepted(findings(unit, tmp_path)) == []
    library(unit, tmp_path)
    assert verdict(watched(unit, tmp_path, "clang"), rows_of(unit), limit_of(unit)) == (0, 0, 0)
