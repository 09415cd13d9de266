"""Boards with a Cortex-M, emulated by qemu; images for them, and what these take."""

import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from hydroservo.export.unit import CModule
from tools.targets.compilers import FLAGS, output, warnings
from tools.targets.sources import FOLDER, write_unit

COMPILER = "arm-none-eabi-gcc"
LONGEST = 120.0  # [s] that an image may run


class Board(NamedTuple):
    """A processor, and the machine of qemu that has it.

    Attributes:
        name: of the processor.
        flags: of the compiler.
        machine: as qemu calls it.
    """

    name: str
    flags: tuple[str, ...]
    machine: str


HARD = ("-mthumb", "-mfloat-abi=hard")
BOARDS = (
    Board("Cortex-M4F", ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", *HARD), "mps2-an386"),
    Board("Cortex-M7", ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", *HARD), "mps2-an500"),
)


def compiled(unit: CModule, board: Board, folder: Path, flags: Sequence[str] = ()) -> Path:
    """The unit alone as an object, with -O2 and every warning an error.

    Raises:
        ToolError: with the compiler's words.
    """
    target = folder / f"{unit.prefix}.o"
    source = write_unit(unit, folder)
    output([COMPILER, *FLAGS, *warnings(unit), "-O2", *board.flags, *flags, "-c", source, "-o", target])
    return target


def image(board: Board, sources: Sequence[Path], folder: Path) -> Path:
    """Sources and objects with a main among them, linked for a board; includes are looked up in the folder.

    Raises:
        ToolError: with the compiler's or the linker's words.
    """
    target = folder / f"{board.machine}.elf"
    flags = [*FLAGS, "-O2", *board.flags, "--specs=rdimon.specs", "-nostartfiles"]
    script = f"-Wl,--script={FOLDER / 'target.ld'}"
    output([COMPILER, *flags, "-I", folder, script, FOLDER / "startup.c", *sources, "-lm", "-o", target])
    return target


def ran(board: Board, built: Path, options: Sequence[str] = ()) -> subprocess.CompletedProcess[str]:
    """An image run to its end: what it printed, and its main's status; 99 is a processor's fault.

    Raises:
        subprocess.TimeoutExpired: it does not end.
    """
    semihosting = ["-semihosting-config", "enable=on,target=native"]
    command = ["qemu-system-arm", "-machine", board.machine, "-nographic", *semihosting, *options]
    return subprocess.run(
        [*command, "-kernel", built],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
    )
