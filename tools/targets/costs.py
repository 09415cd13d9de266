"""What an exported unit takes on a Cortex-M: memory, stack and instructions."""

import re
from pathlib import Path
from typing import NamedTuple

from hydroservo.export.unit import CModule
from tools.targets.boards import COMPILER, Board, compiled, image, ran
from tools.targets.compilers import FLAGS, ToolError, output
from tools.targets.sources import Rows, write_measure
from tools.targets.stack import OPTIONS, deepest

# An instruction takes 2^5 ns of the emulator's time, and a tick of the board's timer 40 ns.
TIMED = ("-icount", "shift=5")
TICKS = 32.0 / 40.0  # for each instruction
KEPT = (".text", ".rodata", ".data", ".bss")


class Sections(NamedTuple):
    """Bytes of an object, or of a linked image.

    Attributes:
        text: instructions.
        rodata: constants.
        data: variables that have a value at the start.
        bss: variables that are 0 at the start.
    """

    text: int
    rodata: int
    data: int
    bss: int


class Costs(NamedTuple):
    """Of one unit on one board.

    Attributes:
        own: of its object.
        linked: with all that it takes of the compiler's and the C library.
        state: bytes of its state.
        parameters: bytes of its parameters; 0 where they are inlined.
        stack: bytes of the deepest chain of its own functions below init or step, as the compiler knows it.
        touched: bytes of stack that init and step wrote to on the board, the libraries' included.
        instructions: of a step, mean over the inputs.
    """

    own: Sections
    linked: Sections
    state: int
    parameters: int
    stack: int
    touched: int
    instructions: int


def costs(unit: CModule, board: Board, inputs: Rows, folder: Path) -> Costs:
    """Measures a unit with -O2.

    Raises:
        ToolError: it does not compile, or does not run to its end.
    """
    built = compiled(unit, board, folder, OPTIONS)
    graph = built.with_suffix(".ci")
    touched, taken = measured(unit, board, inputs, built)
    return Costs(
        sections(built),
        sections(linked(unit, board, built)),
        size(unit, board, "state", folder),
        0 if unit.inlined else size(unit, board, "parameters", folder),
        max(deepest(graph, f"{unit.prefix}_{name}") for name in ("init", "step")),
        touched,
        taken,
    )


def measured(unit: CModule, board: Board, inputs: Rows, built: Path) -> tuple[int, int]:
    """Bytes of stack, and instructions of a step, on the emulated board."""
    folder = built.parent
    done = ran(board, image(board, [built, write_measure(unit, inputs, folder)], folder), TIMED)
    if done.returncode != 0:
        raise ToolError(f"{board.machine} ended with {done.returncode}\n{done.stdout}{done.stderr}")
    touched, whole, around = (int(word) for word in done.stdout.split())
    return touched, 1 + round((whole - around) / TICKS / len(inputs))  # around takes one itself


def linked(unit: CModule, board: Board, built: Path) -> Path:
    """The object with what it needs of the libraries, and nothing else."""
    target = built.with_suffix(".elf")
    used = ["init", *([] if unit.inlined else ["defaults"])]
    kept = [f"-Wl,--gc-sections,--entry={unit.prefix}_step"]
    kept += [f"-Wl,--undefined={unit.prefix}_{name}" for name in used]
    output(
        [COMPILER, *board.flags, "--specs=nosys.specs", "-nostartfiles", *kept, built, "-lm", "-o", target]
    )
    return target


def sections(built: Path) -> Sections:
    """Bytes of each kind, functions and objects in sections of their own included."""
    found = dict.fromkeys(KEPT, 0)
    for name, count in re.findall(
        r"^(\.\w+)\S*\s+(\d+)", output(["arm-none-eabi-size", "-A", built]), re.MULTILINE
    ):
        if name in found:
            found[name] += int(count)
    return Sections(*found.values())


def size(unit: CModule, board: Board, record: str, folder: Path) -> int:
    """Bytes of a record."""
    source, target = folder / "size.c", folder / "size.o"
    text = f'#include "{unit.prefix}.h"\nchar size[sizeof({unit.prefix}_{record})];\n'
    source.write_text(text, encoding="utf-8")
    output([COMPILER, *FLAGS, *board.flags, "-I", folder, "-c", source, "-o", target])
    return sections(target).bss
