"""A periodic demand with a flat spectrum."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.sources import CHOSEN


@role(Reference)
class Multisine(NamedTuple):
    """N equal harmonics of one frequency, with Schroeder's phases and exact derivatives.

    r = amplitude/sqrt(2 N) sum_k sin(2 pi k f0 t - pi k (k - 1)/N),   k = 1 ... N

    Its rms is half the amplitude, and its peak stays within the amplitude: these phases keep the crest factor
    below 1.94 for every N up to 1000, as the tests show.

    Source: Schroeder, IEEE Trans. Information Theory 16(1), 1970, for the phases; Pintelon and Schoukens,
    System Identification, 2012, ch. 5, for the signal.
    Fails as a start from rest: the first value is not 0. Its second derivative grows as N^2.
    """

    amplitude: Annotated[float, Field("y", "bound of the peak, twice the rms")]
    frequency: Annotated[float, Field("Hz", "lowest frequency f0", CHOSEN, above=0)] = 0.25
    harmonics: Annotated[int, Field("", "number of harmonics N", CHOSEN, at_least=1, at_most=1000)] = 20

    def at(self, t: float) -> Demand:
        omega = 2.0 * math.pi * self.frequency
        each = self.amplitude / ops.sqrt(2.0 * self.harmonics)
        value = rate = second_rate = 0.0
        for i in range(self.harmonics):
            k = i + 1.0
            angle = k * omega * t - math.pi * k * (k - 1.0) / self.harmonics
            value += each * ops.sin(angle)
            rate += each * k * omega * ops.cos(angle)
            second_rate -= each * k * omega * k * omega * ops.sin(angle)
        return Demand(value, rate, second_rate)
