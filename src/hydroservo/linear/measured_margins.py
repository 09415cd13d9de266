"""The margins of a measured open loop, where it is coherent."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.formatting import number

if TYPE_CHECKING:
    import xarray as xr

COHERENT = 0.9  # of the tones on both sides of a crossover, at least

Vector = NDArray[np.float64]


class Crossing(NamedTuple):
    """A margin, and where it is from.

    Attributes:
        margin: a factor for the gain, [rad] for the phase; nan where there is none.
        frequency: of the crossover [Hz].
        remark: why there is no margin; empty where there is one.
    """

    margin: float
    frequency: float
    remark: str


def measured_margins(data: "xr.Dataset") -> tuple[Crossing, Crossing]:
    """The gain margin and the phase margin of a measured loop, with lines between its tones.

    The least margin counts. One is given only where the tones on both sides of every crossover have a
    coherence of 0.9.

    Args:
        data: what ``bode`` returned, measured.

    Source: Astrom, Murray, Feedback Systems, 2008, sec. 9.3.
    Fails for crossovers between two tones that cross twice.
    """
    response, coherence = data["open_measured"].values, data["open_coherence"].values
    tones = data["tone"].values
    with np.errstate(divide="ignore"):  # of a tone that nothing answers, whose coherence is 0
        size = np.log(np.abs(response))
    phase = np.unwrap(np.angle(response))
    turned = np.sin(0.5 * phase + 0.5 * math.pi)  # 0 at -180 degrees, and every turn from there
    gain = least(turned, -size, tones, coherence, "\N{MINUS SIGN}180\N{DEGREE SIGN}")
    late = np.abs(np.remainder(phase, 2.0 * math.pi) - math.pi)
    return (
        gain._replace(margin=math.exp(gain.margin)),
        least(size, late, tones, coherence, "0 dB"),
    )


def least(crossed: Vector, margin: Vector, tones: Vector, coherence: Vector, level: str) -> Crossing:
    """The least margin above 0 where another number is 0, by lines over the logarithm of the frequency."""
    found = []
    for i in np.flatnonzero(np.sign(crossed[:-1]) * np.sign(crossed[1:]) < 0.0):
        share = crossed[i] / (crossed[i] - crossed[i + 1])
        frequency = float(tones[i] * (tones[i + 1] / tones[i]) ** share)
        weakest = float(coherence[i : i + 2].min())
        if weakest < COHERENT:
            heard = f"coherence {weakest:.2f} at {number(frequency)} Hz"
            return Crossing(math.nan, frequency, f"{heard}; try a larger --amplitude or another --band")
        value = float(margin[i] + share * (margin[i + 1] - margin[i]))
        if value > 0.0:
            found.append(Crossing(value, frequency, ""))
    none = Crossing(math.nan, math.nan, f"no tone near {level}: widen --band")
    return min(found, key=lambda one: one.margin, default=none)
