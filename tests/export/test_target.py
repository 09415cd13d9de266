"""Exported C on emulated boards with a Cortex-M4F and an M7; each measurement is shown to measure."""

from pathlib import Path

import pytest

from hydroservo.export.unit import CModule
from tests.support.export.toy import toy
from tests.support.export.variants import changed, each_unit, idling, inputs
from tests.support.needs import needs
from tools.targets.boards import BOARDS, COMPILER, Board, compiled, image, ran
from tools.targets.compilers import ToolError, output
from tools.targets.costs import Sections, costs, sections
from tools.targets.stack import deepest
from tools.targets.symbols import foreign, undefined

pytestmark = pytest.mark.nightly

EMULATOR = "qemu-system-arm"
FAULT = "*(volatile int *)0xFFFFFFF0u = 1;"

each_board = pytest.mark.parametrize("board", BOARDS, ids=[board.name for board in BOARDS])


@each_unit
@each_board
def test_a_board_calls_nothing_but_roots_and_its_compilers_helpers(
    unit: CModule, board: Board, tmp_path: Path
) -> None:
    needs(COMPILER)
    called = undefined(compiled(unit, board, tmp_path), "arm-none-eabi-nm")
    assert foreign(called) == set()
    if unit.real == "float" or board.name == "Cortex-M7":
        assert called == set(), "the processor has all of its arithmetic"


def test_a_board_without_doubles_is_seen_to_call_helpers(tmp_path: Path) -> None:
    needs(COMPILER)
    assert "__aeabi_dmul" in undefined(compiled(toy(), BOARDS[0], tmp_path), "arm-none-eabi-nm")


@each_board
@pytest.mark.parametrize("status", [0, 3])
def test_an_image_prints_and_gives_its_status(board: Board, status: int, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR)
    main = tmp_path / "main.c"
    main.write_text(f'#include <stdio.h>\nint main(void) {{ puts("here"); return {status}; }}\n')
    done = ran(board, image(board, [main], tmp_path))
    assert (done.returncode, done.stdout) == (status, "here\n")


@each_board
def test_a_fault_is_a_status(board: Board, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR)
    main = tmp_path / "main.c"
    main.write_text(f"int main(void) {{ {FAULT} }}\n")
    assert ran(board, image(board, [main], tmp_path)).returncode == 99


@each_unit
@each_board
def test_costs(unit: CModule, board: Board, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR)
    found = costs(unit, board, inputs(unit), tmp_path)
    real = 4 if unit.real == "float" else 8
    assert found.state == 3 * real
    assert found.parameters == (0 if unit.inlined else 4 * real)
    assert found.own.rodata == found.parameters
    assert (found.own.data, found.own.bss, found.linked.data, found.linked.bss) == (0, 0, 0, 0)
    assert 30 < found.own.text <= found.linked.text < 4000
    assert found.stack <= found.touched < found.stack + 100
    assert 10 < found.instructions < 1000


@each_board
def test_costs_grow_with_what_is_done(board: Board, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR)
    rows = inputs(toy())
    less, more = (costs(idling(count), board, rows, tmp_path) for count in (1000, 2000))
    assert more.instructions == less.instructions + 1000
    assert more.own == less.own._replace(text=less.own.text + 2000)  # nop has two bytes
    assert (more.stack, more.touched) == (less.stack, less.touched)


FRAME = """\
    volatile double room[100];
    room[0] = demand->value;
    const double error = 0.0 * room[0] +"""


@each_board
def test_a_larger_frame_is_a_deeper_stack(board: Board, tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR)
    roomy = changed(toy(), "    const double error =", FRAME)
    less, more = (costs(unit, board, inputs(unit), tmp_path) for unit in (toy(), roomy))
    assert 800 <= more.stack - less.stack < 820
    assert 800 <= more.touched < more.stack + 100


def test_sections_are_an_objects(tmp_path: Path) -> None:
    needs(COMPILER)
    source = tmp_path / "a.c"
    source.write_text("const char text[3] = {1};\nint data[4] = {1};\ndouble bss[5];\n")
    output([COMPILER, "-c", source, "-o", tmp_path / "a.o"])
    assert sections(tmp_path / "a.o") == Sections(0, 3, 16, 40)


GRAPH = """\
graph: { title: "a.c"
node: { title: "step" label: "step\\na.c:1:2\\n24 bytes (static)" }
node: { title: "a.c:left" label: "left\\na.c:3:4\\n8 bytes (static)" }
node: { title: "a.c:right" label: "right\\na.c:5:6\\n16 bytes (static)" }
node: { title: "sqrt" label: "sqrt\\nmath.h:112:15" shape : ellipse }
edge: { sourcename: "step" targetname: "a.c:left" label: "a.c:1:9" }
edge: { sourcename: "step" targetname: "a.c:right" label: "a.c:1:9" }
edge: { sourcename: "a.c:left" targetname: "a.c:right" label: "a.c:1:9" }
edge: { sourcename: "a.c:right" targetname: "sqrt" }
}
"""


def test_the_deepest_chain_counts(tmp_path: Path) -> None:
    graph = tmp_path / "a.ci"
    graph.write_text(GRAPH)
    assert deepest(graph, "step") == 24 + 8 + 16
    assert deepest(graph, "a.c:right") == 16
    with pytest.raises(ValueError, match=r"a.ci has no init"):
        deepest(graph, "init")
    graph.write_text(GRAPH.replace('"sqrt" }', '"step" }'))
    with pytest.raises(ValueError, match="step calls itself"):
        deepest(graph, "step")
    graph.write_text(GRAPH.replace("8 bytes (static)", "8 bytes (dynamic)"))
    with pytest.raises(ValueError, match=r"the stack of a\.c:left is dynamic"):
        deepest(graph, "step")


def test_an_image_that_stops_is_an_error(tmp_path: Path) -> None:
    needs(COMPILER, EMULATOR)
    unit = changed(
        toy(), "    const double error", "    *(volatile int *)0xFFFFFFF0u = 1;\n    const double error"
    )
    with pytest.raises(ToolError, match="ended with 99"):
        costs(unit, BOARDS[0], inputs(toy()), tmp_path)
