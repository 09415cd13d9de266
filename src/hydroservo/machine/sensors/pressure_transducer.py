"""A pressure transducer and the converter that reads it."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import PressureSensor, role
from hydroservo.core.signals import Draws
from hydroservo.core.sources import CHOSEN


class PressureTransducerState(NamedTuple):
    """The reading, and the pressure that the transducer has followed."""

    value: Annotated[float, Field("Pa", "measured pressure")]
    followed: Annotated[float, Field("Pa", "pressure behind the transducer's own lag")]


@role(PressureSensor)
class PressureTransducer(NamedTuple):
    """A transducer of limited range with a lag, an offset and noise, read by a converter of so many bits.

    With the span R = range_high - range_low and n_k normal with mean 0 and standard deviation 1::

        f_k = f_(k-1) + h/(tau + h) (p_k - f_(k-1))               starting at the first pressure
        r_k = f_k + (offset + noise n_k) R                        clipped to the range
        value = range_low + q nearest((r_k - range_low)/q)        q = R/2^bits

    The highest code of the converter reads range_high - q. With 0 bits there is none, and the value is r_k.

    Source: the entries of any transducer's data sheet; backward Euler for the lag; rounding as in Widrow and
    Kollar, Quantization Noise, 2008, ch. 1.
    Fails where tau is not many sample periods long nor much shorter than one; and noise is white here, so
    its power spreads up to half the sampling rate.
    """

    range_low: Annotated[float, Field("Pa", "lower end of the range", at_most=0)]
    range_high: Annotated[float, Field("Pa", "upper end of the range", above=0)]
    noise: Annotated[float, Field("", "rms of the noise, share of the span", CHOSEN, at_least=0)] = 1e-3
    offset: Annotated[float, Field("", "zero offset, share of the span", "0: adjusted")] = 0.0
    bits: Annotated[
        int, Field("", "of the analogue-to-digital converter; 0: none", CHOSEN, at_least=0, at_most=32)
    ] = 12
    time_constant: Annotated[
        float, Field("s", "time constant tau of the transducer", "0: at once", at_least=0)
    ] = 0.0

    def smoothed(self) -> "PressureTransducer":
        return self._replace(bits=0)

    def init(self) -> PressureTransducerState:
        return PressureTransducerState(0.0, math.nan)

    def step(
        self, s: PressureTransducerState, pressure: float, draws: Draws, dt: float
    ) -> PressureTransducerState:
        before = ops.where(ops.isnan(s.followed), pressure, s.followed)
        followed = before + dt / (self.time_constant + dt) * (pressure - before)
        span = self.range_high - self.range_low
        error = self.offset + self.noise * ops.normal(draws.seed, draws.stream, draws.sample)
        read = ops.clip(followed + error * span, self.range_low, self.range_high)
        codes = 1 << self.bits
        step = span / codes
        code = ops.minimum(codes - 1.0, ops.nearest((read - self.range_low) / step))
        value = ops.where(self.bits > 0, self.range_low + step * code, read)
        return PressureTransducerState(value, followed)
