"""How large the signals of a loop are, by which an environment divides them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import replace
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.runs.stepping import SteppedRuns


class SignalSizes(NamedTuple):
    """Sizes of signals.

    Attributes:
        signals: the largest absolute value of each in a run, 1 of its SI unit where it stays 0.
        error: half of the range of the demand; its largest absolute value where it is constant.
    """

    signals: NDArray[np.float64]
    error: float


def signal_sizes(loop: Loop, paths: Sequence[str]) -> SignalSizes:
    """The sizes of what is seen of a loop, from a run of it under its own law.

    Args:
        loop: the loop.
        paths: of what is seen, as :class:`~hydroservo.runs.stepping.SteppedRuns` has it.
    """
    at_samples = replace(loop, {"simulation.record_period": loop.simulation.period})
    recorded = ["controller.u", "reference.value"]
    data = quietly(simulate)(at_samples, record=recorded, metrics=[], strict=True)
    commands, demand = (np.nan_to_num(data[path].to_numpy()) for path in recorded)
    substeps = data.attrs.get("substeps", loop.simulation.substeps)
    runs = SteppedRuns(replace(loop, {"simulation.substeps": substeps}), {}, 1)
    first = np.zeros(1, dtype=np.int64)
    runs.begin(first, sets=first, seeds=np.array([loop.simulation.seed]))
    largest = np.zeros(len(paths))
    for command in commands[:-1]:
        largest = np.fmax(largest, [abs(runs[path].item()) for path in paths])
        runs.advance(np.array([command]))
    spread = 0.5 * float(np.ptp(demand)) or float(np.max(np.abs(demand)))
    return SignalSizes(np.where(np.isfinite(largest) & (largest > 0.0), largest, 1.0), spread or 1.0)
