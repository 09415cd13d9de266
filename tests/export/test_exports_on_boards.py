"""What scenarios export, on emulated boards."""

from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest

from hydroservo.export.c.project import write_c_project
from hydroservo.export.unit import CModule, Part, Precision
from hydroservo.export.vectors import Vectors
from tests.support.export.cases import SINGLE, Case, each_board, each_case, named, unit_of, vectors_of
from tests.support.needs import needs
from tools.targets.boards import COMPILER, Board, compiled, image, ran
from tools.targets.host import library
from tools.targets.symbols import foreign, undefined

pytestmark = pytest.mark.nightly

EMULATOR = "qemu-system-arm"
FEW = 100  # samples of a machine: the Cortex-M4F has no doubles in hardware


@each_case
@each_board
def test_boards_call_nothing_but_roots_and_helpers(case: Case, board: Board, tmp_path: Path) -> None:
    needs(COMPILER)
    assert foreign(undefined(compiled(unit_of(case), board, tmp_path), "arm-none-eabi-nm")) == set()


def replayed(unit: CModule, vectors: Vectors, board: Board, folder: Path) -> CompletedProcess[str]:
    """The replay that is exported beside the code, on a board."""
    write_c_project(unit, vectors, folder)
    sources = [folder / f"{unit.prefix}.c", folder / f"{unit.prefix}_replay.c"]
    return ran(board, image(board, sources, folder))


@each_board
@each_case
def test_boards_pass_the_replay(case: Case, board: Board, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR, "gcc")
    vectors = vectors_of(case)
    if case.part is not Part.CONTROLLER:
        vectors = vectors._replace(inputs=vectors.inputs[:FEW], expected=vectors.expected[:FEW])
    done = replayed(unit_of(case), vectors, board, tmp_path)
    assert done.returncode == 0, done.stdout
    if case.precision is Precision.DOUBLE:
        count = len(vectors.expected)
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
