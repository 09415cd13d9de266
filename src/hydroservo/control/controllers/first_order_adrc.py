"""Active disturbance rejection of order one: an integrator, and all else a disturbance."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.this_signal import THIS_SIGNAL
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core import ops
from hydroservo.core.assumptions import (
    Assumption,
    Facts,
    above,
    below,
    oil_faster,
    robust,
    sampled_faster,
    within_limit,
)
from hydroservo.core.block import Field
from hydroservo.core.roles import ControlledSignal, Controller, role
from hydroservo.core.signals import Demand, Measurement


class FirstOrderADRCState(NamedTuple):
    """The last command, and what the extended state observer estimates."""

    u: Annotated[float, Field("V", "command")]
    signal: Annotated[float, Field("y", "estimate of the {y}")]
    disturbance: Annotated[float, Field("y/s", "estimate of the total disturbance f")]


@role(Controller)
class FirstOrderADRC(NamedTuple):
    """Linear active disturbance rejection control of a signal y that is taken for y' = b0 u + f.

    All that is not b0 u is the disturbance f. An extended state observer with both poles at w_o gives y and
    f from the measured signal and the mean command applied, z = exp(-w_o h)::

        y_ahead = y + h (f + b0 u_applied)
        y := y_ahead + (1 - z^2) (y_measured - y_ahead),   f := f + (1 - z)^2/h (y_measured - y_ahead)
        u  = sat( (r' + w_c (r - y) - f)/b0 )

    A command that is limited is known to the observer, so nothing winds up. For a position b0 is the velocity
    gain of machine and valve, for a velocity behind a valve of first order that over its time constant.

    Source: Gao, American Control Conference 2003, doi:10.1109/ACC.2003.1242516; Herbst, Electronics 2(3),
    2013; the observer that uses the newest sample: Miklosovic, Radke, Gao, American Control Conference 2006,
    doi:10.1109/ACC.2006.1656547.
    Fails where b0 is wrong by half or more, by its margins; the observer's bandwidth is limited by delay and
    by the oil's resonance, and by noise, which w_o passes on to the command.
    """

    input_gain: Annotated[float, Field("y/(s V)", "b0, rate of the {y} per command", above=0)]
    bandwidth: Annotated[float, Field("rad/s", "w_c of the loop", above=0)]
    observer_bandwidth: Annotated[float, Field("rad/s", "w_o of the observer", above=0)]
    saturation: Saturation = Saturation()
    controls: ControlledSignal = THIS_SIGNAL

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        gain = self.bandwidth * abs(facts.response(self.bandwidth))
        return adrc_assumptions(self.input_gain, gain, "y/(s V)", self.observer_bandwidth, facts)

    def init(self) -> FirstOrderADRCState:
        return FirstOrderADRCState(0.0, math.nan, 0.0)

    def step(self, s: FirstOrderADRCState, y: Measurement, r: Demand, dt: float) -> FirstOrderADRCState:
        measured = self.controls.of(y, y.command)
        ahead = s.signal + dt * (s.disturbance + self.input_gain * y.command)
        lost = ops.isnan(ahead)  # at the start, and after a sample that was not a number
        miss = ops.where(lost, 0.0, measured - ahead)
        z = ops.power(math.e, -self.observer_bandwidth * dt)
        signal = ops.where(lost, measured, ahead + (1.0 - z * z) * miss)
        disturbance = ops.where(lost, 0.0, s.disturbance + (1.0 - z) * (1.0 - z) / dt * miss)
        wanted = r.rate + self.bandwidth * (r.value - signal) - disturbance
        return FirstOrderADRCState(self.saturation.apply(wanted / self.input_gain), signal, disturbance)


def adrc_assumptions(
    input_gain: float, machine_gain: float, unit: str, observer_bandwidth: float, facts: Facts
) -> Sequence[Assumption]:
    """That b0 is near the machine's gain at w_c, and that samples and oil are faster than the observer."""
    meaning = "b0 is above half of what the machine's gain is at w_c"
    return [
        above("input gain", meaning, input_gain, 0.5 * machine_gain, unit),
        below("input gain", "b0 is below three times that", input_gain, 3.0 * machine_gain, unit),
        sampled_faster(observer_bandwidth, facts, "w_o"),
        oil_faster(observer_bandwidth, facts, "w_o"),
        robust(facts),
        within_limit(facts),
    ]
