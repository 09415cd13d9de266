"""What is called chatter, measured on the command of a run."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

SHARE = 1e-3  # of the command's limit, beyond which a swing is chatter
TREND = 5  # degree of the polynomial that is taken for what the demand asks


class Swing(NamedTuple):
    """How a command swings about its trend.

    Attributes:
        amplitude: half its range, without the hundredth part at either end [V].
        frequency: of the strongest line of its spectrum [rad/s].
    """

    amplitude: float
    frequency: float


def swing(command: ArrayLike, period: float) -> Swing:
    """The swing of a command over a window, less what a polynomial of degree five follows.

    A command chatters where the amplitude is above ``SHARE`` of its limit.

    Args:
        command: at the samples of the window [V].
        period: between them [s].

    Source: chosen here.
    Fails in a window in which the demand jumps: what follows the jump counts as a swing.
    """
    u = np.asarray(command, dtype=np.float64)
    if not np.isfinite(u).all():
        return Swing(math.nan, math.nan)
    x = np.linspace(-1.0, 1.0, len(u))
    left = u - np.polynomial.Polynomial.fit(x, u, TREND)(x)
    low, high = np.quantile(left, [0.01, 0.99])
    lines = np.abs(np.fft.rfft(left * np.hanning(len(u))))
    frequency = 2.0 * math.pi * float(np.argmax(lines)) / (len(u) * period)
    return Swing(0.5 * float(high - low), frequency)
