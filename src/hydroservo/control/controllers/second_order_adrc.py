"""Active disturbance rejection of order two: a double integrator, and all else a disturbance."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.this_signal import THIS_SIGNAL
from hydroservo.control.controllers.first_order_adrc import adrc_assumptions
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts
from hydroservo.core.block import Field
from hydroservo.core.roles import ControlledSignal, Controller, role
from hydroservo.core.signals import Demand, Measurement


class SecondOrderADRCState(NamedTuple):
    """The last command, and what the extended state observer estimates."""

    u: Annotated[float, Field("V", "command")]
    signal: Annotated[float, Field("y", "estimate of the {y}")]
    rate: Annotated[float, Field("y/s", "estimate of its rate")]
    disturbance: Annotated[float, Field("y/s^2", "estimate of the total disturbance f")]


@role(Controller)
class SecondOrderADRC(NamedTuple):
    """Linear active disturbance rejection control of a signal y that is taken for y'' = b0 u + f.

    All that is not b0 u is the disturbance f. An extended state observer with its three poles at w_o gives y,
    y' and f from the measured signal and the mean command applied, with z = exp(-w_o h) and e what is
    measured less y_ahead::

        y_ahead = y + h y' + h^2/2 (f + b0 u_applied),   y'_ahead = y' + h (f + b0 u_applied)
        y  := y_ahead + (1 - z^3) e,   y' := y'_ahead + 3/(2 h) (1 - z)^2 (1 + z) e
        f  := f + (1 - z)^3/h^2 e
        u   = sat( (r'' + w_c^2 (r - y) + 2 w_c (r' - y') - f)/b0 )

    A command that is limited is known to the observer, so nothing winds up. A position behind a valve that is
    fast has b0 = K_v/tau with the valve's time constant, a velocity g1 g2 of the machine.

    Source: as :class:`FirstOrderADRC`.
    Fails where f has to hold the stiffness of the oil: a velocity's has its resonance below the observer's
    bandwidth or is not followed at all; and where b0 is wrong by half or more, by its margins.
    """

    input_gain: Annotated[float, Field("y/(s^2 V)", "b0, second rate of the {y} per command", above=0)]
    bandwidth: Annotated[float, Field("rad/s", "w_c of the loop", above=0)]
    observer_bandwidth: Annotated[float, Field("rad/s", "w_o of the observer", above=0)]
    saturation: Saturation = Saturation()
    controls: ControlledSignal = THIS_SIGNAL

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        gain = self.bandwidth**2 * abs(facts.response(self.bandwidth))
        return adrc_assumptions(self.input_gain, gain, "y/(s^2 V)", self.observer_bandwidth, facts)

    def init(self) -> SecondOrderADRCState:
        return SecondOrderADRCState(0.0, math.nan, 0.0, 0.0)

    def step(self, s: SecondOrderADRCState, y: Measurement, r: Demand, dt: float) -> SecondOrderADRCState:
        measured = self.controls.of(y, y.command)
        known = s.disturbance + self.input_gain * y.command
        ahead = s.signal + dt * (s.rate + 0.5 * dt * known)
        lost = ops.isnan(ahead)  # at the start, and after a sample that was not a number
        miss = ops.where(lost, 0.0, measured - ahead)
        z = ops.power(math.e, -self.observer_bandwidth * dt)
        faded = 1.0 - z
        signal = ops.where(lost, measured, ahead + (1.0 - z * z * z) * miss)
        rate = ops.where(lost, 0.0, s.rate + dt * known + 1.5 / dt * faded * faded * (1.0 + z) * miss)
        disturbance = ops.where(lost, 0.0, s.disturbance + faded * faded * faded / (dt * dt) * miss)
        pull = self.bandwidth * (self.bandwidth * (r.value - signal) + 2.0 * (r.rate - rate))
        u = self.saturation.apply((r.second_rate + pull - disturbance) / self.input_gain)
        return SecondOrderADRCState(u, signal, rate, disturbance)
