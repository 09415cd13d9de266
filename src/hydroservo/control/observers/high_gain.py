"""A high-gain disturbance observer: what the measured state did besides the model, through a low-pass."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.observers.estimates import Estimates
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, below, model_stable, valve_faster
from hydroservo.core.block import Field
from hydroservo.core.roles import Observer, role
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel


@role(Observer)
class HighGainObserver(NamedTuple):
    """Each disturbance follows what the measured state did besides the model, with a rate of its own.

    dd_i/dt = L_i (d_Li - d_i), sampled without differentiation: with x_ahead where the model would have
    brought the last measurement under the mean command applied and the last estimates::

        d_i := d_i + (1 - exp(-L_i h)) (x_i - x_i,ahead)/h

    Where the sample period is short against the machine's own times, a step of a disturbance is followed to
    1 - exp(-n L_i h) after n samples. It starts with the
    first measurement and no disturbance, and anew after a sample that was not a number.

    Source: Won, Kim, Shin, Chung, IEEE Trans. Control Systems Technology 23(2), 2015 (unverified), sampled.
    Fails under noise, which it divides by the sample period: 0.5 mm/s at 1 kHz are 0.5 m/s^2 times
    1 - exp(-L_1 h); where the valve lags, for L_2 above about one over its time constant; and at sample
    periods that KalmanObserver does not bear either.
    """

    velocity_rate: Annotated[float, Field("1/s", "rate L_1 of the estimate of d_L1", above=0)]
    hydraulic_force_rate: Annotated[float, Field("1/s", "rate L_2 of the estimate of d_L2", above=0)]

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        noise = facts.noise[0] / facts.period * -math.expm1(-self.velocity_rate * facts.period)
        meaning = "the noise of the estimate of d_L1 is below what d_L1 is"
        return [
            valve_faster(self.hydraulic_force_rate, facts, "L_2"),
            model_stable(facts),
            below("noise", meaning, noise, facts.disturbances[0].value, "m/s^2", measured=True),
        ]

    def init(self) -> Estimates:
        return Estimates(0.0, 0.0, 0.0, 0.0, math.nan, math.nan)

    def step(self, s: Estimates, model: DesignModel, y: Measurement, dt: float) -> Estimates:
        ahead = model.ahead(s.velocity, s.hydraulic_force, y.command, s.d1, s.d2, dt)
        lost = ops.isnan(ahead.velocity)  # as is the hydraulic force, on which it depends
        gain_1 = (1.0 - ops.power(math.e, -self.velocity_rate * dt)) / dt
        gain_2 = (1.0 - ops.power(math.e, -self.hydraulic_force_rate * dt)) / dt
        return Estimates(
            s1=0.0,
            s2=0.0,
            d1=ops.where(lost, 0.0, s.d1 + gain_1 * (y.velocity - ahead.velocity)),
            d2=ops.where(lost, 0.0, s.d2 + gain_2 * (y.hydraulic_force - ahead.hydraulic_force)),
            velocity=y.velocity,
            hydraulic_force=y.hydraulic_force,
        )
