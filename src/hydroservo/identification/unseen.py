"""The states in which a segment begins and that no sensor shows."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import leaves
from hydroservo.identification.experiment import GIVEN, Experiment, kernel_for
from hydroservo.identification.observer import rows_of
from hydroservo.identification.segments import Segment
from hydroservo.identification.spikes import noise_of

FIRST = 12  # samples that show whether something moves
CLEAR = 3.0  # deviations of noise, from which a change is one


def begins_in_motion(segments: Sequence[Segment], number: int) -> bool:
    """Whether a segment goes on after a gap, or its first samples show a velocity or a slope above noise."""
    own = segments[number]
    if any(one.log == own.log for one in segments[:number]):
        return True
    for name, values in own.measured.items():
        places = np.flatnonzero(np.isfinite(values))[:FIRST]
        if places.size < FIRST:
            continue
        slope, level = np.polyfit(places, values[places], 1)
        change = level if name == "velocity" else slope * places[-1]
        if abs(change) > CLEAR * noise_of(values):
            return True
    return False


def with_unseen(one: Experiment) -> Experiment:
    """The experiment with the states that its log does not show, and how far the machine moves them.

    A log that begins in motion, or goes on after a gap, begins with some velocity and some opening of its
    valve. States that stay where they are, or a machine that is lost, leave nothing to seek.
    """
    from hydroservo.engine.lane_traces import traced

    own = dict(leaves(one.loop))
    columns = {path: np.array([own[path]]) for path in one.varied if path in own}
    kernel, started = kernel_for(one, columns)
    paths = [path for path in one.varied if path.startswith(GIVEN) and path not in one.start]
    rows = rows_of(kernel, [path.removeprefix(GIVEN) for path in paths])
    states: list[NDArray[np.float64]] = []
    traced(
        kernel,
        started,
        one.segment.samples,
        one.segment.period,
        lambda _, memory: states.append(memory[rows, 0].copy()),
    )
    sizes = np.std(states, axis=0)
    moved = zip(paths, sizes, strict=True) if np.isfinite(sizes).all() else ()
    return one._replace(unseen={path: (own[path], float(size)) for path, size in moved if size > 0.0})
