"""A loop in C as WebAssembly: compiled, and held against the simulation."""

import ctypes
import shutil
from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import HydroservoError, LoopError
from hydroservo.core.outputs import temporary_folder
from hydroservo.export.compilers import compile_file
from hydroservo.export.texts import render
from hydroservo.export.unit import CModule, Signal

PACKAGES = ("ziglang", "wasmtime")
TARGET = ("cc", "-target", "wasm32-wasi")
LIBRARY = ("-mexec-model=reactor", "-Wl,--no-entry", "-Wl,--strip-all", "-mcpu=generic+nontrapping_fptoint")

Numbers = NDArray[np.float64]


def check_packages() -> None:
    """Refuse to go on without what compiles to WebAssembly, and what runs it here."""
    missing = [name for name in PACKAGES if find_spec(name) is None]
    if missing:
        problem = f"a page needs the package{'s' * (len(missing) > 1)} {' and '.join(missing)}"
        raise HydroservoError(f"{problem}: pip install 'hydroservo[page]'")


def zig() -> str:
    """The program of the package ziglang."""
    place = find_spec("ziglang")
    found = shutil.which("zig", path=str(Path(str(place and place.origin)).parent))
    if found is None:
        raise HydroservoError("the package ziglang has no zig for this computer")
    return found


def wasm_of(unit: CModule, sliders: Sequence[Signal]) -> bytes:
    """A loop as WebAssembly, with ``begin``, ``advance``, ``sliders`` and ``row``.

    Args:
        unit: of a whole loop, in double precision, whose parameters are not inlined.
        sliders: those of its parameters that can be set before a run.

    Raises:
        CompilerError: the compiler fails.
    """
    known = {"x": unit, "sliders": sliders}
    with temporary_folder() as folder:
        for name, text in {
            f"{unit.prefix}.h": unit.header,
            f"{unit.prefix}.c": unit.source,
            "page.c": render("page.c", known),
        }.items():
            (folder / name).write_text(text, encoding="utf-8")
        words = [*LIBRARY, "page.c", f"{unit.prefix}.c"]
        return compile_file(folder, words, "page.wasm", [zig(), *TARGET]).read_bytes()


class Replay(NamedTuple):
    """What WebAssembly gives.

    Attributes:
        rows: a row for each recorded sample that was reached, a column for each number of the state.
        last: the numbers after the last sample, of which the metrics are those of the run.
        reached: number of the last sample, or of the one after which the run was lost.
    """

    rows: Numbers
    last: Numbers
    reached: int


class WasmLoop:
    """WebAssembly of :func:`wasm_of` in this process.

    Args:
        code: the bytes.
        unit: what was compiled.
        sliders: how many.
    """

    def __init__(self, code: bytes, unit: CModule, sliders: int) -> None:
        import wasmtime

        engine = wasmtime.Engine()
        self.store: Any = wasmtime.Store(engine)
        made = wasmtime.Instance(self.store, wasmtime.Module(engine, code), [])
        self.exports: Any = made.exports(self.store)
        self.sliders = self.doubles("sliders", sliders)
        self.row = self.doubles("row", len(unit.states))

    def doubles(self, name: str, count: int) -> Numbers:
        """The memory that a function of the module names."""
        start = self.exports[name](self.store)
        first = ctypes.addressof(self.exports["memory"].data_ptr(self.store).contents)
        return np.ctypeslib.as_array((ctypes.c_double * count).from_address(first + start))

    def replay(self, values: Sequence[float], samples: int, stride: int) -> Replay:
        """A run with some values of the sliders."""
        self.sliders[:] = values
        self.exports["begin"](self.store)
        rows = [row for k in range(0, samples, stride) for row in self.at(k)]
        reached = self.exports["advance"](self.store, samples - 1)
        return Replay(np.array(rows), self.row.copy(), reached)

    def at(self, sample: int) -> Iterator[Numbers]:
        """The row of a sample, if it is reached."""
        if self.exports["advance"](self.store, sample) == sample:
            yield self.row.copy()


def check_bits(replay: Replay, run: Mapping[str, Any], columns: Mapping[str, int], when: str) -> None:
    """Refuse numbers that are not those of a strict run.

    Args:
        replay: of the same loop.
        run: the trace, read by path and by the name of a metric.
        columns: the number of the column of each path and metric.
        when: with which numbers it ran, in words.

    Raises:
        LoopError: some number differs in a bit.
    """
    for name, column in columns.items():
        expected = np.asarray(run[name], dtype=np.float64)
        found = replay.rows[:, column] if expected.ndim else replay.last[column]
        expected = expected[: len(replay.rows)] if expected.ndim else expected
        same = (found.view(np.int64) == expected.view(np.int64)) | (np.isnan(found) & np.isnan(expected))
        if not np.all(same):
            raise LoopError(f"nothing is written: {when}, {name} of the page is not that of the simulation")
