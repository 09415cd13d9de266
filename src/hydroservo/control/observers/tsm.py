"""The terminal sliding mode disturbance observer of the paper."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.observers.boundary_layer import BoundaryLayer
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, above, per_second, sampled_faster, supposed
from hydroservo.core.block import Field
from hydroservo.core.roles import Observer, Realisation, role
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel


class TSMObserverState(NamedTuple):
    """Surfaces, estimates, and what is predicted for the next sample."""

    s1: Annotated[float, Field("m/s", "observer surface s1 = v1 - x1")]
    s2: Annotated[float, Field("N", "observer surface s2 = v2 - x2")]
    d1: Annotated[float, Field("m/s^2", "estimate of the lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "estimate of the lumped disturbance d_L2")]
    velocity: Annotated[float, Field("m/s", "measured velocity, which the law takes")]
    hydraulic_force: Annotated[float, Field("N", "measured hydraulic force, which the law takes")]
    v1: Annotated[float, Field("m/s", "velocity predicted for the next sample")]
    v2: Annotated[float, Field("N", "hydraulic force predicted for the next sample, without the command")]
    g2: Annotated[float, Field("N/(s V)", "input gain g2 of this period")]


@role(Observer)
class TSMObserver(NamedTuple):
    """Estimates of the lumped disturbances from two terminal sliding surfaces s_i = v_i - x_i.

    With r_i(s) = -k_i s - D_i sgn(s) - eps_i |s|^a sgn(s)::

        dv1/dt = r1(s1) + f1 + g1 x2,   d1 = r1(s1)
        dv2/dt = r2(s2) + f2 + g2 u,    d2 = r2(s2)

    sampled with a forward step; how sgn is realised is the nested block. It starts with v_i = x_i,
    and does so again after a sample that was not a number.

    Source: eqs. (12)-(14) of doi:10.1007/s42401-021-00087-w; one exponent a = p/q per observer, both 5/7.
    Fails to reach its surfaces where D_i <= sup |d_Li| (Lemma 2): the estimates then follow with the
    bandwidth of k_i and eps_i alone. The printed D_2 is short of that by orders of magnitude. The exponent
    is at least 0.1 because the implicit realisation's Newton steps reach rounding only from there.
    """

    linear_gain_1: Annotated[float, Field("1/s", "observer gain k_d1", at_least=0)]
    linear_gain_2: Annotated[float, Field("1/s", "observer gain k_d2", at_least=0)]
    switching_gain_1: Annotated[float, Field("m/s^2", "switching gain D_1", at_least=0)]
    switching_gain_2: Annotated[float, Field("N/s", "switching gain D_2", at_least=0)]
    power_gain_1: Annotated[float, Field("m^(2/7)/s^(9/7)", "power gain eps_1 [(m/s)^(1-a)/s]", at_least=0)]
    power_gain_2: Annotated[float, Field("N^(2/7)/s", "power gain eps_2 [N^(1-a)/s]", at_least=0)]
    exponent: Annotated[float, Field("", "exponent a = p/q", at_least=0.1, below=1)]
    realisation: Realisation = BoundaryLayer()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        gains = (self.switching_gain_1, self.switching_gain_2)
        channels = zip(("1", "2"), gains, facts.disturbances, facts.noise, ("m/s", "N"), strict=True)
        found = [
            sampled_faster(max(self.linear_gain_1, self.linear_gain_2), facts, "the larger of k_d1 and k_d2")
        ]
        for i, gain, largest, noise, unit in channels:
            meaning = f"D_{i} is above the largest d_L{i}"
            found.append(above(f"Lemma 2, D_{i}", meaning, gain, largest, per_second(unit), measured=True))
            found.extend(supposed(self.realisation, gain, noise, facts.period, unit))
        return found

    def init(self) -> TSMObserverState:
        return TSMObserverState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, math.nan, math.nan, 0.0)

    def step(self, s: TSMObserverState, model: DesignModel, y: Measurement, dt: float) -> TSMObserverState:
        predicted = s.v2 + dt * s.g2 * y.command
        v1 = ops.where(ops.isnan(s.v1), y.velocity, s.v1)
        v2 = ops.where(ops.isnan(predicted), y.hydraulic_force, predicted)
        c1 = self.realisation.first(
            v1 - y.velocity, self.linear_gain_1, self.switching_gain_1, self.power_gain_1, self.exponent, dt
        )
        c2 = self.realisation.second(
            v2 - y.hydraulic_force,
            self.linear_gain_2,
            self.switching_gain_2,
            self.power_gain_2,
            self.exponent,
            dt,
        )
        model_acceleration = model.f1(y.velocity) + model.g1() * y.hydraulic_force
        return TSMObserverState(
            s1=c1.surface,
            s2=c2.surface,
            d1=c1.estimate,
            d2=c2.estimate,
            velocity=y.velocity,
            hydraulic_force=y.hydraulic_force,
            v1=v1 + dt * (c1.estimate + model_acceleration),
            v2=v2 + dt * (c2.estimate + model.f2(y.velocity, y.hydraulic_force)),
            g2=model.g2(y.hydraulic_force, y.command),
        )
