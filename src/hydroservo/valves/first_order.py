"""A servo valve with a first-order spool."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field, MeteringEdges
from hydroservo.sources import TSMC_EHA_2021
from hydroservo.valves.orifice import Orifice

__all__ = ["FirstOrderValve", "FirstOrderValveState"]


class FirstOrderValveState(NamedTuple):
    """The spool's position."""

    opening: Annotated[float, Field("m", "spool position x_v")]


class FirstOrderValve(NamedTuple):
    """A spool that follows its command with a first-order lag.

    T_sv dx_v/dt = K_sv u - x_v, the commanded position held within +-x_max

    Source: T_sv is listed in Sec. 4 of doi:10.1007/s42401-021-00087-w and used nowhere there.
    Fails near the valve's bandwidth, where a real spool is of second order and slew limited.
    """

    gain: Annotated[float, Field("m/V", "servo valve gain K_sv", TSMC_EHA_2021, above=0)] = 5e-4
    time_constant: Annotated[float, Field("s", "spool time constant T_sv", TSMC_EHA_2021, above=0)] = 0.01
    max_opening: Annotated[float, Field("m", "spool limit x_max", TSMC_EHA_2021, above=0)] = 5e-3
    orifice: MeteringEdges = Orifice()

    def init(self) -> FirstOrderValveState:
        return FirstOrderValveState(0.0)

    def deriv(self, s: FirstOrderValveState, u: float) -> FirstOrderValveState:
        commanded = ops.clip(self.gain * u, -self.max_opening, self.max_opening)
        return FirstOrderValveState((commanded - s.opening) * (1.0 / self.time_constant))

    def opening(self, s: FirstOrderValveState, u: float) -> float:
        return s.opening
