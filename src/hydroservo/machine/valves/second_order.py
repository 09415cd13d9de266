"""A servo valve with a second-order spool."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import MeteringEdges, Valve, role
from hydroservo.core.sources import CHOSEN, DATASHEET
from hydroservo.machine.valves.orifice import check_opens

UNLIMITED = 1e6  # [m/s] beyond any spool
BRAKE = 5.0  # rate at which the limits are neared, in natural frequencies

Gain = Annotated[float, Field("m/V", "servo valve gain K_sv", above=0)]
MaxOpening = Annotated[float, Field("m", "spool limit x_max", above=0)]
SlewLimit = Annotated[float, Field("m/s", "largest speed of the spool", "no limit", above=0)]
Hysteresis = Annotated[float, Field("m", "full width of the hysteresis as an opening", "0: none", at_least=0)]
Frequency90 = Annotated[float, Field("Hz", "frequency of -90 degrees", DATASHEET, above=0)]
Frequency3dB = Annotated[float, Field("Hz", "frequency of -3 dB", DATASHEET, above=0)]


class SecondOrderValveState(NamedTuple):
    """The spool's position and speed."""

    opening: Annotated[float, Field("m", "spool position x_v")]
    speed: Annotated[float, Field("m/s", "spool speed")]


@role(Valve)
class SecondOrderValve(NamedTuple):
    """A spool with inertia, a largest speed, a limited travel and hysteresis.

    With x_c = K_sv u held within +-x_max, and hysteresis of full width h as a play in the spool's position::

        d2x/dt2 = wn^2 (clip(x, x_c - h/2, x_c + h/2) - x) - 2 zeta wn dx/dt

    held between the two accelerations with which speed and position just keep to their limits. Upwards that
    is the smaller of k (v_max - v) and k^2 (x_max - x) - 2 k v, with k = 5 wn, downwards their mirror image.
    So the spool nears a limit as a lag of rate k does and never passes it, one that rests at x_max has no
    outward speed, and the right side stays continuous. A sine at wn is limited from 98 % of v_max on.

    Source: Merritt, Hydraulic Control Systems, 1967 (a servo valve as a second-order system); limits and play
    are chosen here.
    Fails above the natural frequency, where a real spool has a third pole, and where its speed depends on
    the pilot pressure.
    """

    gain: Gain
    natural_frequency: Annotated[float, Field("rad/s", "natural frequency of the spool", above=0)]
    max_opening: MaxOpening
    orifice: MeteringEdges
    damping_ratio: Annotated[float, Field("", "damping ratio of the spool", CHOSEN, above=0)] = 0.8
    slew_limit: SlewLimit = UNLIMITED
    hysteresis: Hysteresis = 0.0

    @classmethod
    def from_response(
        cls,
        frequency_90: Frequency90,
        frequency_3db: Frequency3dB,
        gain: Gain,
        max_opening: MaxOpening,
        orifice: MeteringEdges,
        slew_limit: SlewLimit = UNLIMITED,
        hysteresis: Hysteresis = 0.0,
    ) -> "SecondOrderValve":
        """The valve with a measured small-signal frequency response.

        The lag is 90 degrees at wn, so wn = 2 pi f_90; with r = f_3dB/f_90, the amplitude is 1/sqrt(2) at
        f_3dB for zeta^2 = (2 - (1 - r^2)^2)/(4 r^2).

        Raises:
            ParameterError: no second-order spool has these two frequencies.
        """
        ratio = frequency_3db / frequency_90
        beyond = 1.0 - ratio * ratio
        left = 2.0 - beyond * beyond
        if not (ratio > 0.0 and left > 0.0):
            allowed = "must be below 1.55 times frequency_90: no damping gives a second-order spool more"
            raise ParameterError("frequency_3db", frequency_3db, allowed)
        wn, damping_ratio = 2.0 * math.pi * frequency_90, 0.5 * math.sqrt(left) / ratio
        return cls(gain, wn, max_opening, orifice, damping_ratio, slew_limit, hysteresis)

    def check(self) -> None:
        check_opens(self.orifice, self.max_opening)
        if not self.hysteresis < 2.0 * self.max_opening:
            allowed = f"must be below twice max_opening, {2.0 * self.max_opening:g} [m]"
            raise ParameterError("hysteresis", self.hysteresis, allowed)

    def init(self) -> SecondOrderValveState:
        return SecondOrderValveState(0.0, 0.0)

    def deriv(self, s: SecondOrderValveState, u: float) -> SecondOrderValveState:
        x, v = s.opening, s.speed
        wn, k = self.natural_frequency, BRAKE * self.natural_frequency
        commanded = ops.clip(self.gain * u, -self.max_opening, self.max_opening)
        target = ops.clip(x, commanded - 0.5 * self.hysteresis, commanded + 0.5 * self.hysteresis)
        free = wn * (wn * (target - x) - 2.0 * self.damping_ratio * v)
        most = k * ops.minimum(self.slew_limit - v, k * (self.max_opening - x) - 2.0 * v)
        least = -k * ops.minimum(self.slew_limit + v, k * (self.max_opening + x) + 2.0 * v)
        return SecondOrderValveState(v, ops.clip(free, least, most))

    def opening(self, s: SecondOrderValveState, u: float) -> float:
        return s.opening
