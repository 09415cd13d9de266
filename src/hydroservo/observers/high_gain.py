"""A high-gain disturbance observer: what the measured state did besides the model, through a low-pass."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.plants.design_model import DesignModel
from hydroservo.roles import Observer, role
from hydroservo.signals import Measurement

__all__ = ["HighGainObserver", "HighGainObserverState"]


class HighGainObserverState(NamedTuple):
    """Estimates at this sample. The surfaces s1 and s2, which a law expects of an observer, are 0."""

    s1: Annotated[float, Field("m/s", "0: no observer surface s1")]
    s2: Annotated[float, Field("N", "0: no observer surface s2")]
    d1: Annotated[float, Field("m/s^2", "estimate of the lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "estimate of the lumped disturbance d_L2")]
    velocity: Annotated[float, Field("m/s", "measured velocity, which the law takes")]
    load_force: Annotated[float, Field("N", "measured load force, which the law takes")]


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
    1 - exp(-L_1 h); and, where the valve lags, for L_2 above about one over its time constant.
    """

    velocity_rate: Annotated[float, Field("1/s", "rate L_1 of the estimate of d_L1", above=0)]
    load_force_rate: Annotated[float, Field("1/s", "rate L_2 of the estimate of d_L2", above=0)]

    def init(self) -> HighGainObserverState:
        return HighGainObserverState(0.0, 0.0, 0.0, 0.0, math.nan, math.nan)

    def step(
        self, s: HighGainObserverState, model: DesignModel, y: Measurement, dt: float
    ) -> HighGainObserverState:
        ahead = model.ahead(s.velocity, s.load_force, y.command, s.d1, s.d2, dt)
        lost = ops.isnan(ahead.velocity)  # as is the load force, on which it depends
        gain_1 = (1.0 - ops.power(math.e, -self.velocity_rate * dt)) / dt
        gain_2 = (1.0 - ops.power(math.e, -self.load_force_rate * dt)) / dt
        return HighGainObserverState(
            s1=0.0,
            s2=0.0,
            d1=ops.where(lost, 0.0, s.d1 + gain_1 * (y.velocity - ahead.velocity)),
            d2=ops.where(lost, 0.0, s.d2 + gain_2 * (y.load_force - ahead.load_force)),
            velocity=y.velocity,
            load_force=y.load_force,
        )
