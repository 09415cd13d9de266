"""An exported unit compiled for this machine, and run over rows of inputs."""

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydroservo.export.unit import CModule
from tools.targets.compilers import FLAGS, output, warnings
from tools.targets.sources import Rows, width, write_program, write_unit


class Library(NamedTuple):
    """A unit loaded into this process."""

    unit: CModule
    loaded: ctypes.CDLL

    def run(
        self, inputs: Rows, parameters: Mapping[str, float] | None = None, restart: int | None = None
    ) -> Rows:
        """The states after each step; a row for each of the inputs, a column for each of the unit's states.

        Args:
            inputs: a row a step, a column for each signal of each of the unit's arguments.
            parameters: values by path, in place of the unit's own.
            restart: rows after which it begins anew, with init.

        Raises:
            AssertionError: a command that step returned is not the state's, bit for bit.
        """
        states: Rows = self.states(inputs, parameters, restart)[1:]
        return states

    def start(self, parameters: Mapping[str, float] | None = None) -> Rows:
        """The states after init."""
        states: Rows = self.states(np.empty((0, width(self.unit))), parameters, None)[0]
        return states

    def states(self, inputs: Rows, parameters: Mapping[str, float] | None, restart: int | None) -> Rows:
        rows, given = reals(self.unit, inputs), values(self.unit, parameters)
        states = np.empty((len(rows) + 1, len(self.unit.states)), rows.dtype)
        call = getattr(self.loaded, f"{self.unit.prefix}_rows")
        call.restype = ctypes.c_long
        counts = ctypes.c_long(len(rows)), ctypes.c_long(restart or len(rows) + 1)
        wrong = call(address(given), address(rows), *counts, address(states))
        assert wrong == 0, f"{wrong} commands are not those of the state"  # noqa: S101 - documented
        return states


class Program(NamedTuple):
    """A unit in an executable that reads its inputs from a file."""

    unit: CModule
    path: Path

    def run(
        self,
        inputs: Rows,
        parameters: Mapping[str, float] | None = None,
        restart: int | None = None,
        under: Sequence[str | Path] = (),
    ) -> Rows:
        """As that of a library, in a process of its own, which another tool may watch.

        Raises:
            ToolError: the process stopped with an error, such as a sanitizer's.
        """
        folder = self.path.parent
        rows, given = reals(self.unit, inputs), values(self.unit, parameters)
        rows.tofile(folder / "inputs.bin")
        counts = [str(len(rows)), str(restart or len(rows) + 1)]
        command = [*under, self.path, folder / "inputs.bin", *counts, folder / "states.bin"]
        if given is not None:
            given.tofile(folder / "parameters.bin")
            command.append(folder / "parameters.bin")
        output(command)
        states: Rows = np.fromfile(folder / "states.bin", rows.dtype)
        return states.reshape(-1, len(self.unit.states))[1:]


def library(unit: CModule, folder: Path, compiler: str = "gcc", flags: Sequence[str] = ("-O2",)) -> Library:
    """A unit compiled without a single warning, and loaded.

    Raises:
        ToolError: with the compiler's words.
    """
    rows, _ = write_program(unit, folder)
    target = folder / f"{unit.prefix}-{compiler}{''.join(flags)}.so"
    objects = compiled(unit, folder, compiler, [*flags, "-fPIC"])
    output([compiler, *FLAGS, *flags, "-fPIC", "-shared", "-I", folder, objects, rows, "-o", target, "-lm"])
    return Library(unit, ctypes.CDLL(str(target)))


def program(unit: CModule, folder: Path, compiler: str = "gcc", flags: Sequence[str] = ("-O2",)) -> Program:
    """A unit compiled without a single warning, into an executable.

    Raises:
        ToolError: with the compiler's words.
    """
    target = folder / f"{unit.prefix}-{compiler}"
    objects = compiled(unit, folder, compiler, flags)
    around = write_program(unit, folder)
    output([compiler, *FLAGS, *flags, "-I", folder, objects, *around, "-o", target, "-lm"])
    return Program(unit, target)


def compiled(unit: CModule, folder: Path, compiler: str, flags: Sequence[str]) -> Path:
    """The unit alone as an object, every warning an error."""
    target = folder / f"{unit.prefix}.o"
    output([compiler, *FLAGS, *warnings(unit), *flags, "-c", write_unit(unit, folder), "-o", target])
    return target


def reals(unit: CModule, inputs: Rows) -> Rows:
    with np.errstate(over="ignore"):  # a number too large for a float is an infinity
        rows: Rows = np.ascontiguousarray(inputs, np.float32 if unit.real == "float" else np.float64)
    if rows.ndim != 2 or rows.shape[1] != width(unit):
        raise ValueError(f"inputs of shape {rows.shape}; a step is given {width(unit)} numbers")
    return rows


def values(unit: CModule, parameters: Mapping[str, float] | None) -> Rows | None:
    """All parameters in their order; nothing where they are the unit's own."""
    if parameters is None:
        return None
    unknown = parameters.keys() - {signal.path for signal in unit.parameters}
    if unknown or unit.inlined:
        raise ValueError(f"no parameters: {', '.join(sorted(unknown)) or 'they are inlined'}")
    numbers = [parameters.get(signal.path, signal.value) for signal in unit.parameters]
    return np.array(numbers, np.float32 if unit.real == "float" else np.float64)


def address(array: Rows | None) -> ctypes.c_void_p | None:
    return None if array is None else array.ctypes.data_as(ctypes.c_void_p)
