"""sgn as a set, solved for in each step (backward Euler)."""

from collections.abc import Sequence
from typing import NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, below, per_second
from hydroservo.core.roles import Realisation, role
from hydroservo.core.signals import Correction


@role(Realisation)
class Implicit(NamedTuple):
    """The reaching law evaluated at the surface of the next instant, with xi in Sgn(s_hat).

    Given the measured s, find s_hat such that::

        s_hat + dt (k s_hat + eps |s_hat|^a sgn(s_hat) + D xi) = s

    If |s| <= dt D then s_hat = 0 and the surface is reached. Otherwise |s_hat| = sigma solves
    (1 + dt k) sigma + dt eps sigma^a = |s| - dt D, which has one root. d_hat = (s_hat - s)/dt:
    while sliding, the true disturbance averaged over the last period, without chatter.

    Source: Acary, Brogliato, Orlov, IEEE Trans. Automatic Control 57(5), 2012 (the set-valued step);
    a terminal power term added.
    Fails where |d| > D: s rests off 0, and the estimate follows with the bandwidth of k and eps alone,
    not within one period.
    """

    def supposes(self, D: float, noise: float, dt: float, unit: str) -> Sequence[Assumption]:
        """What it asks of a switching gain D [unit/s], on a surface that is measured with some noise."""
        return [below("noise", "the noise over a sample period is below D", noise / dt, D, per_second(unit))]

    def first(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        sigma = ops.power_root(ops.absolute(s) - dt * D, 1.0 + dt * k, dt * eps, a)
        surface = ops.copysign(sigma, s)
        return Correction(surface, (surface - s) * (1.0 / dt))

    def second(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        return self.first(s, k, D, eps, a, dt)
