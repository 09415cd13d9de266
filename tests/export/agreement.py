"""What it means that exported C gives the bits of strict Python."""

from pathlib import Path

import numpy as np
from benchmarks.targets.host import library
from benchmarks.targets.sources import Rows
from numpy.typing import NDArray

from hydroservo import Loop, simulate
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from needs import needs

__all__ = ["assert_same_run", "same_bits"]


def same_bits(a: Rows, b: Rows) -> NDArray[np.bool_]:
    """Where two arrays hold the same bits; all nan are one."""
    return (a.view(np.uint64) == b.view(np.uint64)) | (np.isnan(a) & np.isnan(b))


def assert_same_run(loop: Loop, folder: Path, *, compiled: bool) -> None:
    """A whole loop in C gives the bits of its strict simulation."""
    needs("gcc")
    unit = exported_unit(loop, Part.LOOP, prefix="loop", title="a loop")
    data = simulate(loop, strict=compiled, compiled=compiled)
    stride = round(loop.simulation.record_period / loop.simulation.period)
    count = data.sizes["time"]
    built = library(unit, folder)
    later = built.run(np.empty(((count - 1) * stride, 0)))[stride - 1 :: stride]
    rows = np.vstack([built.start(), later])
    for i, signal in enumerate(unit.states):
        if signal.path != "sample":
            assert same_bits(data[signal.path].values, np.ascontiguousarray(rows[:, i])).all(), signal.path
    paths = {path for path in data.data_vars if data[path].dims}
    assert paths == {signal.path for signal in unit.states} - {"sample"}
