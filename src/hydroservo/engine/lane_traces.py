"""What many runs side by side show at each sample: the trajectories that a batch does not keep."""

import ctypes
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.engine.lanes import CompiledLanes, LaneGroup
from hydroservo.engine.native import Native, RunError, c_argument


def monitor_traces(
    kernel: CompiledLanes,
    parameters: Mapping[str, NDArray[np.float64]],
    samples: int,
    dt: float,
    after: Callable[[int, NDArray[np.float64]], None] | None = None,
) -> NDArray[np.float64]:
    """What the monitors that hear samples hold after each sample, shape (samples, numbers, LANES).

    Lanes beyond the runs given repeat the last of these; a lane whose state was lost is nan throughout.

    Args:
        kernel: of a study of so many samples.
        parameters: arrays of shape (runs,), of at most LANES runs, by path.
        samples: of each run.
        dt: between them [s].
        after: called with the number of each sample once the machine has moved on from it, and the memory of
            the lanes, in which it may change states and parameters.
    """
    group, layout = LaneGroup(kernel, parameters), kernel.layout
    held, alive = group.memory[layout.sums : layout.step_sums], group.memory[layout.alive]
    advance = bind_arrays(kernel.call, kernel.constants, kernel.tables, group.memory)
    out = np.empty((samples, *held.shape))
    for k in range(samples):
        advance(k, k + 1, dt)
        out[k] = held
        if after is not None:
            after(k, group.memory)
    out[:, :, alive == 0.0] = np.nan
    return out


def bind_arrays(call: Native, *arrays: NDArray[Any]) -> Callable[[int, int, float], None]:
    """A kernel whose arrays stay where they are: what it takes besides is quick to give."""
    result = ctypes.c_int64()
    places = (ctypes.byref(result), *map(c_argument, arrays))
    function, whole, real = call.function, ctypes.c_int64, ctypes.c_double

    def advance(first: int, last: int, dt: float) -> None:
        if function(*places, whole(first), whole(last), real(dt)) != 0:
            raise RunError("a block raised an exception, which compiled code cannot carry")

    return advance
