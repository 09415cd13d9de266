"""The super-twisting algorithm by the usual implicit step, which forgets the disturbance."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.error_dynamics.super_twisting import twisting_assumptions
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, Peak, below
from hydroservo.core.block import Field
from hydroservo.core.roles import ErrorDynamics, role
from hydroservo.core.signals import VelocityError


class NaiveSuperTwistingState(NamedTuple):
    """What is asked for at this sample, the surface, and the integral of its sign."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the surface")]
    sigma: Annotated[float, Field("m/s^2", "sliding surface")]
    learnt: Annotated[float, Field("m/s^3", "integral w of the surface's sign")]


@role(ErrorDynamics)
class NaiveSuperTwisting(NamedTuple):
    """:class:`SuperTwisting` sampled as if nothing disturbed the surface over the period ahead.

    With sigma, k1 and k2 as there::

        z_k = sigma_k + h v_k,   v_k = -k1 |z_k|^(1/2) sgn(z_k) + w_k,   w_k = w_(k-1) - h k2 Sgn(z_k)

    Where |sigma + h w| <= h^2 k2, z_k = 0 and v_k = -sigma_k/h whatever w was: no chatter, and sigma is h
    times the disturbance, not h^2 L. It is here to show what that costs.

    Source: Brogliato, Polyakov, Efimov, IEEE Trans. Automatic Control 65(8), 2020 (unverified).
    Fails as SuperTwisting does, and leaves an error under a constant disturbance.
    """

    surface_gain: Annotated[float, Field("1/s", "gain c of the error in the surface", above=0)]
    disturbance_rate: Annotated[float, Field("m/s^4", "bound L on the disturbance's rate", above=0)]

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        meaning = "h g1 d_L2, which stays on its surface, is below 1 % of what the demand makes there"
        load, most = facts.disturbances[1], 0.01 * self.surface_gain * facts.demand.value
        left = Peak(facts.period * facts.model.g1() * load.value, load.time)
        return [
            *twisting_assumptions(self.surface_gain, self.disturbance_rate, facts),
            below("disturbance", meaning, left, most, "m/s^2", measured=True),
        ]

    def init(self) -> NaiveSuperTwistingState:
        return NaiveSuperTwistingState(0.0, 0.0, 0.0, 0.0)

    def step(self, s: NaiveSuperTwistingState, error: VelocityError, dt: float) -> NaiveSuperTwistingState:
        k1, k2 = 1.5 * ops.sqrt(self.disturbance_rate), 1.1 * self.disturbance_rate
        sigma = error.rate + self.surface_gain * error.value + error.shift()
        known = sigma + dt * s.learnt
        beyond = ops.absolute(known) - dt * dt * k2
        half = 0.5 * dt * k1
        root = ops.sqrt(half * half + ops.maximum(beyond, 0.0)) - half  # of |z_k|
        learnt = s.learnt - ops.clip(known / dt, -dt * k2, dt * k2)
        drive = learnt - k1 * ops.copysign(root, known)
        return NaiveSuperTwistingState(self.surface_gain * error.rate, -drive, sigma, learnt)
