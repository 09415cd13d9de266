"""The super-twisting algorithm, sampled so that it keeps what it has learnt of the disturbance."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import (
    Assumption,
    Facts,
    below,
    disturbance_slower,
    sampled_faster,
    valve_faster,
)
from hydroservo.core.block import Field
from hydroservo.core.roles import ErrorDynamics, role
from hydroservo.core.signals import VelocityError


class SuperTwistingState(NamedTuple):
    """What is asked for at this sample, the surface, and what the disturbance is compensated with."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the surface")]
    sigma: Annotated[float, Field("m/s^2", "sliding surface")]
    learnt: Annotated[float, Field("m/s^3", "integral w of the surface's sign")]
    drive: Annotated[float, Field("m/s^3", "what the implicit step drives the surface with")]


@role(ErrorDynamics)
class SuperTwisting(NamedTuple):
    """A surface that is reached in finite time against any disturbance whose rate is below a bound L.

    With sigma = de/dt + c e + s', s' the shift by the observer's surfaces, and h the sample period::

        q = c de/dt - v,   dsigma/dt = v + disturbance
        v = -k1 |sigma|^(1/2) sgn(sigma) + w,   dw/dt = -k2 sgn(sigma)

    k1 = 1.5 sqrt(L), k2 = 1.1 L. Sampled by the implicit step of z = sigma + h (v_k - v_(k-1)),

        z_k = z_(k-1) + h (v_k + disturbance),   v_k = -k1 |z_k|^(1/2) sgn(z_k) + w_k,
        w_k = w_(k-1) - h k2 xi,                 xi in Sgn(z_k)

    and what is held over the period is v_k + (v_k - v_(k-1)). On z = 0 that is what the disturbance was a
    sample ago, and sigma stays within h^2 L, the least that any law can do: the usual implicit step, of
    :class:`NaiveSuperTwisting`, forgets the disturbance there and leaves h times its size.

    Source: Levant, Int. J. Control 58(6), 1993 (the algorithm; gains from his IJC 76(9), 2003; both
    unverified). That a modified sliding variable gives h^2 L: Seeber, Andritsch, Automatica 173, 2025,
    doi:10.1016/j.automatica.2024.112027, of which the abstract was read; the step is derived here.
    Fails where the disturbance's rate exceeds L, as at a jump of the demand or of the load, from which it
    recovers with overshoot, and where noise on the surface exceeds h^2 L many times.
    """

    surface_gain: Annotated[float, Field("1/s", "gain c of the error in the surface", above=0)]
    disturbance_rate: Annotated[float, Field("m/s^4", "bound L on the disturbance's rate", above=0)]

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return twisting_assumptions(self.surface_gain, self.disturbance_rate, facts)

    def init(self) -> SuperTwistingState:
        return SuperTwistingState(0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, s: SuperTwistingState, error: VelocityError, dt: float) -> SuperTwistingState:
        k1, k2 = 1.5 * ops.sqrt(self.disturbance_rate), 1.1 * self.disturbance_rate
        sigma = error.rate + self.surface_gain * error.value + error.shift()
        known = sigma + dt * (s.learnt - s.drive)
        beyond = ops.absolute(known) - dt * dt * k2
        half = 0.5 * dt * k1
        root = ops.sqrt(half * half + ops.maximum(beyond, 0.0)) - half  # of |z_k|
        learnt = s.learnt - ops.clip(known / dt, -dt * k2, dt * k2)
        drive = learnt - k1 * ops.copysign(root, known)
        return SuperTwistingState(self.surface_gain * error.rate, s.drive - 2.0 * drive, sigma, learnt, drive)


def twisting_assumptions(surface_gain: float, bound: float, facts: Facts) -> list[Assumption]:
    """The assumptions of super-twisting error dynamics.

    Args:
        surface_gain: c of the error in the surface [1/s].
        bound: L on the rate of g1 d_L2 [m/s^4].
        facts: of the loop.
    """
    noise, least = facts.model.g1() * facts.noise[1], facts.period**2 * bound
    return [
        disturbance_slower("L", bound, facts),
        below("noise", "the surface's noise is below h^2 L", noise, least, "m/s^2"),
        sampled_faster(surface_gain, facts, "c"),
        valve_faster(surface_gain, facts, "c"),
    ]
