"""A servo valve with a first-order spool."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import MeteringEdges, Valve, role
from hydroservo.core.sources import DATASHEET
from hydroservo.machine.valves.orifice import check_opens

Gain = Annotated[float, Field("m/V", "servo valve gain K_sv", above=0)]
MaxOpening = Annotated[float, Field("m", "spool limit x_max", above=0)]
CornerFrequency = Annotated[float, Field("Hz", "frequency of -3 dB and -45 degrees", DATASHEET, above=0)]


class FirstOrderValveState(NamedTuple):
    """The spool's position."""

    opening: Annotated[float, Field("m", "spool position x_v")]


@role(Valve)
class FirstOrderValve(NamedTuple):
    """A spool that follows its command with a first-order lag.

    T_sv dx_v/dt = K_sv u - x_v, the commanded position held within +-x_max

    Source: T_sv is listed in Sec. 4 of doi:10.1007/s42401-021-00087-w and used nowhere there.
    Fails near the valve's bandwidth, where a real spool is of second order and slew limited.
    """

    gain: Gain
    time_constant: Annotated[float, Field("s", "spool time constant T_sv", above=0)]
    max_opening: MaxOpening
    orifice: MeteringEdges

    @classmethod
    def from_corner(
        cls, corner_frequency: CornerFrequency, gain: Gain, max_opening: MaxOpening, orifice: MeteringEdges
    ) -> "FirstOrderValve":
        """The valve whose lag is 45 degrees, and amplitude 1/sqrt(2), at a frequency f: T_sv = 1/(2 pi f).

        Raises:
            ParameterError: the frequency is not above 0.
        """
        if not corner_frequency > 0.0:
            raise ParameterError("corner_frequency", corner_frequency, "must be above 0 [Hz]")
        return cls(gain, 1.0 / (2.0 * math.pi * corner_frequency), max_opening, orifice)

    def check(self) -> None:
        check_opens(self.orifice, self.max_opening)

    def init(self) -> FirstOrderValveState:
        return FirstOrderValveState(0.0)

    def deriv(self, s: FirstOrderValveState, u: float) -> FirstOrderValveState:
        commanded = ops.clip(self.gain * u, -self.max_opening, self.max_opening)
        return FirstOrderValveState((commanded - s.opening) * (1.0 / self.time_constant))

    def opening(self, s: FirstOrderValveState, u: float) -> float:
        return s.opening
