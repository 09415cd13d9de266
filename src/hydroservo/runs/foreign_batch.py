"""Runs of a batch whose loop has an FMU in it: one after the other, each with its own instance."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import declared_metrics, monitors_of
from hydroservo.core.block import Block, replace, value_at
from hydroservo.core.errors import LoopError
from hydroservo.runs.divergence import NOTHING, Loss

if TYPE_CHECKING:
    import xarray as xr


def foreign_batch(
    loop: Loop,
    columns: Mapping[str, NDArray[np.float64]],
    run: "Callable[[Loop], xr.Dataset]",
    cuda: bool,
    progress: Callable[[float], None],
) -> tuple[NDArray[np.float64], list[Loss]]:
    """The metrics of each run, shape (metrics, runs), and what each lost.

    Args:
        loop: that they start from, as it was given.
        columns: what differs, by path.
        run: simulates one loop.
        cuda: whether a CUDA device was asked for.
        progress: called with the fraction of runs done.
    """
    if cuda:
        raise LoopError("a CUDA device cannot run an FMU; leave cuda out")
    names = list(declared_metrics(monitors_of(loop)))
    runs = next(iter(columns.values())).size
    table, losses = np.empty((len(names), runs)), [NOTHING] * runs
    for i in range(runs):
        data = run(replace(loop, row(loop, columns, i)))
        table[:, i] = [float(data[name]) for name in names]
        if data["diverged"]:
            losses[i] = Loss(data.attrs["diverged_by"], float(data["diverged_at"]))
        progress((i + 1) / runs)
    return table, losses


def row(loop: Block, columns: Mapping[str, NDArray[np.float64]], i: int) -> dict[str, float | int]:
    """What one run has of its own, each number of the type that it has in the loop."""
    return {path: type(value_at(loop, path))(values[i]) for path, values in columns.items()}
