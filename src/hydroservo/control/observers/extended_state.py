"""A linear extended state observer for each of the two states: all poles in one place."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.observers.estimates import Estimates
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, model_stable, sampled_faster, valve_faster
from hydroservo.core.block import Field
from hydroservo.core.roles import Observer, role
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel


@role(Observer)
class ExtendedStateObserver(NamedTuple):
    """Each state and its disturbance from its own measurement, with both poles at -w_i.

    In the form that uses the measurement of this sample, with x_ahead where the model brings the last
    estimates under the mean command applied, and z_i = exp(-w_i h)::

        x_i := x_i,ahead + (1 - z_i^2) (y_i - x_i,ahead)
        d_i := d_i + (1 - z_i)^2/h (y_i - x_i,ahead)

    It starts with the first measurement and no disturbance, and anew after a sample that was not a number.
    A :class:`KalmanObserver` differs in its gains alone, which noise and disturbance set there.

    Source: Gao, American Control Conference 2003, doi:10.1109/ACC.2003.1242516 (one bandwidth); Miklosovic,
    Radke, Gao, American Control Conference 2006, doi:10.1109/ACC.2006.1656547 (sampled).
    Fails where the two measurements differ much in their noise: each estimate knows its own alone;
    and at sample periods that KalmanObserver does not bear either.
    """

    velocity_bandwidth: Annotated[float, Field("rad/s", "bandwidth w_1 for velocity and d_L1", above=0)]
    hydraulic_force_bandwidth: Annotated[
        float, Field("rad/s", "bandwidth w_2 for hydraulic force and d_L2", above=0)
    ]

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        fastest = max(self.velocity_bandwidth, self.hydraulic_force_bandwidth)
        return [
            sampled_faster(fastest, facts, "the larger bandwidth"),
            valve_faster(self.hydraulic_force_bandwidth, facts, "the bandwidth of d_L2"),
            model_stable(facts),
        ]

    def init(self) -> Estimates:
        return Estimates(0.0, 0.0, 0.0, 0.0, math.nan, math.nan)

    def step(self, s: Estimates, model: DesignModel, y: Measurement, dt: float) -> Estimates:
        ahead = model.ahead(s.velocity, s.hydraulic_force, y.command, s.d1, s.d2, dt)
        lost = ops.isnan(ahead.velocity)  # as is the hydraulic force, on which it depends
        z1 = ops.power(math.e, -self.velocity_bandwidth * dt)
        z2 = ops.power(math.e, -self.hydraulic_force_bandwidth * dt)
        miss1 = ops.where(lost, 0.0, y.velocity - ahead.velocity)
        miss2 = ops.where(lost, 0.0, y.hydraulic_force - ahead.hydraulic_force)
        return Estimates(
            s1=0.0,
            s2=0.0,
            d1=ops.where(lost, 0.0, s.d1 + (1.0 - z1) * (1.0 - z1) / dt * miss1),
            d2=ops.where(lost, 0.0, s.d2 + (1.0 - z2) * (1.0 - z2) / dt * miss2),
            velocity=ops.where(lost, y.velocity, ahead.velocity + (1.0 - z1 * z1) * miss1),
            hydraulic_force=ops.where(
                lost, y.hydraulic_force, ahead.hydraulic_force + (1.0 - z2 * z2) * miss2
            ),
        )
