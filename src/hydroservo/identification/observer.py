"""Signals shifted in time, and an observer that makes a simulated machine follow a measured one."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import leaves
from hydroservo.identification.log import OUTPUTS

if TYPE_CHECKING:
    from hydroservo.engine.lanes import CompiledLanes

PUSH = "load.push"
STEP = 0.05  # of a sample, for the difference by the shift

Samples = NDArray[np.float64]
CORRECTED = "plant."  # the states of which are corrected, and an unknown force on the rod
MEMORIES = 8.0  # after so many times its memory a gain has settled

Matrix = NDArray[np.float64]
After = Callable[[int, Matrix], None]


def shift_signals(values: Samples, delay: float, whole: int | None = None) -> Samples:
    """Signals as they were so many samples before, by a cubic through four samples.

    Before the first and after the last sample they are held.

    Values have samples first. The cubic goes from one less to two more than ``whole`` samples, by default
    those that end within the delay.

    Source: Lagrange's polynomial.
    Fails between samples over which a signal jumps.
    """
    if whole is None:
        whole = int(np.floor(delay))
    places = np.arange(len(values)) - whole
    return cubic([values[np.clip(places - k, 0, len(values) - 1)] for k in (-1, 0, 1, 2)], delay - whole)


def slope_of_shift(values: Samples, delay: float, whole: int | None = None) -> Samples:
    """How shifted signals change with the delay, per sample."""
    ends = shift_signals(values, delay + STEP, whole), shift_signals(values, delay - STEP, whole)
    return (ends[0] - ends[1]) / (2.0 * STEP)


def cubic(last: Sequence[Samples], f: Samples | float) -> Samples:
    """A signal f samples before the last but one of four, of which the last comes first."""
    weights = (
        f * (f - 1.0) * (2.0 - f) / 6.0,
        (1.0 + f) * (1.0 - f) * (2.0 - f) / 2.0,
        (1.0 + f) * f * (2.0 - f) / 2.0,
        (1.0 + f) * f * (f - 1.0) / 6.0,
    )
    found: Samples = np.sum([weight * one for weight, one in zip(weights, last, strict=True)], axis=0)
    return found


class LogObserver(NamedTuple):
    """What corrects a simulated machine after each sample."""

    measured: Matrix  # what it follows, shape (samples, signals); nan where nothing was
    paths: Sequence[str]  # the numbers that it corrects: states, and the unknown force
    gain: Matrix  # of each on the difference of each measured and simulated signal, shape (numbers, signals)
    whole: int  # about how many samples what is measured comes after what is simulated
    force: float  # that would move the states by their spread within a sample [N]


def memory_rows(kernel: "CompiledLanes", paths: Sequence[str]) -> list[int]:
    """Where some states, and the unknown force, stand in the memory of a group."""
    layout = kernel.layout
    states = {path: layout.states + i for i, (path, _) in enumerate(leaves(kernel.state))}
    return [layout.varied.index(PUSH) if path == PUSH else states[path] for path in paths]


def corrector(
    observer: LogObserver, kernel: "CompiledLanes", offsets: Mapping[str, Matrix], late: Matrix
) -> After:
    """What corrects the lanes of a group once a sample is done: x <- x + K (y - offset - seen).

    What was seen is as late as y is, by a cubic that ends at the last sample: so y - offset - seen is what
    is left of a prediction, which knows nothing of y itself or of what came after it.
    """
    from hydroservo.engine.lanes import LANES

    rows, sums = memory_rows(kernel, observer.paths), kernel.layout.sums
    reads = np.zeros((len(OUTPUTS), LANES))
    for i, name in enumerate(OUTPUTS):
        if name in offsets:
            reads[i] = in_lanes(offsets[name], LANES)
    part = in_lanes(late, LANES) - observer.whole
    last: list[Matrix] = []

    def after(k: int, memory: Matrix) -> None:
        seen = memory[sums : sums + len(OUTPUTS)].copy()
        last[:] = [seen, *last[:3]] if last else [seen] * 4
        place = k - 1 + observer.whole
        if 0 <= place < len(observer.measured):
            apart = observer.measured[place][:, np.newaxis] - reads - cubic(last, part)
            memory[rows] += observer.gain @ np.where(np.isfinite(apart), apart, 0.0)

    return after


def in_lanes(values: Matrix, lanes: int) -> Matrix:
    """Values of runs in as many lanes, of which the last ones repeat the last run."""
    return np.append(values, np.full(lanes - values.size, values[-1]))


def fading_gain(transition: Matrix, seen: Matrix, noise: Matrix, forgetting: float) -> Matrix:
    """The gain of the least squares that forget::

        P <- g^2 F (P - P C'(C P C' + R)^-1 C P) F',   K = F P C'(C P C' + R)^-1

    Whatever the machine itself forgets more slowly than g per sample, the observer forgets at that rate.

    F is in units of the states' spreads, C has shape (signals, n), R is diagonal with the squares of
    ``noise``, and g is above 1. K has shape (n, signals).

    Source: Anderson, Moore, Optimal Filtering, 1979, sec. 6.2 (exponential data weighting).
    Fails to correct what no signal shows: that has next to no gain.
    """
    size = len(transition)
    errors: Matrix = np.diag(noise**2)
    spread: Matrix = np.eye(size)
    gain: Matrix = np.zeros((size, len(seen)))
    for _ in range(math.ceil(MEMORIES / math.log(forgetting))):
        weighted = spread @ seen.T
        gain = np.asarray(np.linalg.solve(seen @ weighted + errors, weighted.T).T, dtype=np.float64)
        rest = np.eye(size) - gain @ seen
        after: Matrix = transition @ (rest @ spread @ rest.T + gain @ errors @ gain.T) @ transition.T
        spread = 0.5 * forgetting**2 * (after + after.T)
    found: Matrix = transition @ gain
    return found
