"""Steady-state Kalman gains of the nominal model."""

import math
from collections.abc import Sequence

import numpy as np

from hydroservo.control.synthesis.gains import computed, no_gain
from hydroservo.control.synthesis.matrix import Matrix
from hydroservo.control.synthesis.riccati import solution
from hydroservo.control.synthesis.sampled import under_white_noise
from hydroservo.core.block import Block


def steady_gains(
    observer: Block, rates: Matrix, seen: Sequence[int], sizes: Sequence[float], period: float
) -> dict[str, float]:
    """The gain L with which measurements correct the states, from the discrete algebraic Riccati equation.

    With F and N the transition and the noise over a period, C what is measured and R its noise::

        P = F P F^T - F P C^T (C P C^T + R)^-1 C P F^T + N,   L = P C^T (C P C^T + R)^-1

    Args:
        observer: the filter; its first four fields are q1 and q2, the intensity of each walk per root second,
            and r1 and r2, the rms of each measurement's noise per sample, and the rest the gains, row by row.
        rates: d/dt of the n states, the last two of which walk at random.
        seen: numbers of the two states that are measured.
        sizes: what the first n - 2 states are scaled by, so that SI numbers of any size go together.
        period: sample period [s].

    Returns:
        The filter's gains by their names, in nine digits.

    Raises:
        ParameterError: there is no steady state, or it is beyond the range of floating-point numbers.

    Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, sec. 9.4.
    Fails where noise is not white, or a measurement has none.
    """
    walks, noise = np.array(observer[:2]), np.array(observer[2:4])
    size = len(rates)
    scale = np.concatenate([sizes, walks * math.sqrt(period)])
    intensity = np.zeros((size, size))
    intensity[-2, -2] = intensity[-1, -1] = 1.0 / period  # of walks in their own scale

    def design() -> list[Matrix]:
        measured = np.eye(size)[list(seen)] * scale / noise[:, np.newaxis]
        transition, added = under_white_noise(rates * scale / scale[:, np.newaxis], intensity, period)
        spread = solution(transition.T, measured.T, added, np.eye(2))
        gain = spread @ measured.T @ np.linalg.inv(measured @ spread @ measured.T + np.eye(2))
        return [gain * scale[:, np.newaxis] / noise]

    (gain,) = computed(design, no_gain(observer, observer._fields[:4], period, "disturbance over noise is"))
    return dict(zip(observer._fields[4:], gain.ravel().tolist(), strict=True))
