"""Arrays between pages that no one may touch: an access outside them ends the process.

Run as a program, it lets a kernel work in such memory:
``python -m tests.support.guarded run|lanes|beyond start|end``.
"""

import ctypes
import mmap
import sys
from typing import Any

import numpy as np

from hydroservo import Loop, Simulation, simulate
from hydroservo.control.controllers import TSMC
from hydroservo.control.references import Recorded
from hydroservo.core.time_series import TimeSeries
from hydroservo.engine import kernel, lanes
from hydroservo.machine.loads import Recorded as RecordedLoad
from hydroservo.runs import batch
from hydroservo.testing.examples import example

PROT_NONE = 0
KEPT: list[mmap.mmap] = []


def guarded(values: np.ndarray, edge: str) -> np.ndarray:
    """A copy of an array that starts at the page after a forbidden one, or ends at the page before one."""
    page = mmap.PAGESIZE
    size = -(-max(values.nbytes, 1) // page) * page
    region = mmap.mmap(-1, size + 2 * page)
    KEPT.append(region)
    address = ctypes.addressof(ctypes.c_char.from_buffer(region))
    for forbidden in (address, address + page + size):
        if ctypes.CDLL(None).mprotect(ctypes.c_void_p(forbidden), ctypes.c_size_t(page), PROT_NONE):
            raise OSError("mprotect")
    start = page + (size - values.nbytes if edge == "end" else 0)
    copy = np.frombuffer(region, values.dtype, values.size, start).reshape(values.shape)
    copy[...] = values
    return copy


def loop(edge: str) -> Loop:
    """A loop with arrays, whose knots end inside the run."""
    time = np.linspace(1e-3, 15e-3, 9)
    series = TimeSeries(*(guarded(part, edge) for part in TimeSeries.from_samples(time, 0.03 * np.sin(time))))
    return example(
        Loop,
        Simulation(0.02, 1e-4, 2, 3e-4),
        reference=Recorded(series),
        load=RecordedLoad(series),
        controller=example(TSMC),
    )


def run(edge: str, rows_missing: int = 0) -> None:
    """A single run with all its memory guarded has the bits of one without."""
    wanted = simulate(loop(edge), strict=True)

    class Guarded(kernel.CompiledRun):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            for name in ("constants", "tables", "states", "running"):
                setattr(self, name, guarded(getattr(self, name), edge))

        def advance(self, first: int, last: int, dt: float, stride: int, out: np.ndarray) -> bool:
            place = guarded(out[: len(out) - rows_missing], edge)
            going = super().advance(first, last, dt, stride, place)
            out[: len(place)] = place
            return going

    kernel.CompiledRun = Guarded  # type: ignore[misc]
    assert simulate(loop(edge), strict=True).identical(wanted)


def side_by_side(edge: str) -> None:
    """A batch with all its memory guarded has the bits of one without."""
    parameters = {"plant.bulk_modulus": np.linspace(3e8, 2e9, 33)}
    wanted = batch.simulate_batch(loop(edge), parameters, strict=True)
    init, aligned = lanes.CompiledLanes.__init__, lanes.aligned_rows

    def started(self: Any, *arguments: Any, **options: Any) -> None:
        init(self, *arguments, **options)
        self.constants, self.tables = guarded(self.constants, edge), guarded(self.tables, edge)

    lanes.CompiledLanes.__init__ = started  # type: ignore[method-assign]
    lanes.aligned_rows = lambda rows: guarded(aligned(rows), edge)
    assert batch.simulate_batch(loop(edge), parameters, strict=True).identical(wanted)


def beyond(edge: str) -> None:
    """A run whose kernel is given a row too few, with what refuses that taken out."""
    kernel.check_rows = lambda *_: None
    run(edge, rows_missing=1)


if __name__ == "__main__":
    {"run": run, "lanes": side_by_side, "beyond": beyond}[sys.argv[1]](sys.argv[2])
    print(f"{len(KEPT)} arrays guarded")
