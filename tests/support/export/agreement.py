"""What it means that exported C gives the bits of strict Python."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydroservo import Loop, simulate
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from tests.support.needs import needs
from tools.targets.host import library
from tools.targets.sources import Rows


def same_bits(a: Rows, b: Rows) -> NDArray[np.bool_]:
    """Where two arrays hold the same bits; all nan are one."""
    return (a.view(np.uint64) == b.view(np.uint64)) | (np.isnan(a) & np.isnan(b))


def assert_same_run(loop: Loop, folder: Path, *, compiled: bool) -> None:
    """A whole loop in C gives the bits of its strict simulation, up to where that was lost if it was."""
    data = simulate(loop, metrics=(), strict=compiled, compiled=compiled)
    found = run_in_c(loop, folder)
    lost = float(data["diverged_at"])
    shown = data["time"].values < (lost if np.isfinite(lost) else np.inf)
    for path, values in found.items():
        assert same_bits(data[path].values[shown], np.ascontiguousarray(values[shown])).all(), path
    assert set(found) == {path for path in data.data_vars if data[path].dims}


def run_in_c(loop: Loop, folder: Path) -> dict[str, NDArray[np.float64]]:
    """What a loop in C gives where its simulation records, by path."""
    needs("gcc")
    unit = exported_unit(loop, Part.LOOP, prefix="loop", title="a loop")
    simulation = loop.simulation
    stride = round(simulation.record_period / simulation.period)
    count = round(simulation.duration / simulation.period) // stride + 1
    built = library(unit, folder)
    later = built.run(np.empty(((count - 1) * stride, 0)))[stride - 1 :: stride]
    rows = np.vstack([built.start(), later])
    columns = {signal.path: np.ascontiguousarray(rows[:, i]) for i, signal in enumerate(unit.states)}
    del columns["sample"]
    return columns
