"""A body that swings at the tip of a mechanism."""

from typing import Annotated, Any, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.constants import GRAVITY
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Carried, Mechanism, role
from hydroservo.core.signals import Tip
from hydroservo.core.sources import CHOSEN


class SwingingLoadState(NamedTuple):
    """How the body hangs."""

    angle: Annotated[float, Field("rad", "angle phi of the body from hanging straight down, towards X")]
    rate: Annotated[float, Field("rad/s", "rate of that angle")]


@role(Carried)
class SwingingLoad(NamedTuple):
    """A body on a hinge at the mechanism's tip: a load on a cart, the second link of a crane.

    Its centre of gravity is c below the hinge where it hangs, its moment of inertia about the hinge
    I = J + m c^2. The tip's place P = (X, Y) moves with the rod as P' v, ' = d/dx, and the part it sits on
    turns by tau v. With t = (cos phi, sin phi), n = (-sin phi, cos phi), M and R the mechanism's own inertia
    and resistance, and the hinge's torque T = b (dphi/dt - tau v)::

        (M + m P'.P') dv/dt + m c P'.t phi'' = F - R - m P'.P'' v^2 - m c P'.n (dphi/dt)^2 - m g Y' + tau T
        m c P'.t dv/dt + I phi'' = -m c P''.t v^2 - m g c sin phi - T

    Held still, it swings with omega^2 = m g c/I. A body without inertia about its centre, J = 0, is a mass on
    a line of length c; a mechanism whose tip does not move feels it not at all.

    Source: Lagrange's equations of the body and the mechanism; with a level cart, the overhead crane of
    textbooks of dynamics.
    Fails as a rope that goes slack, for it pushes as it pulls, and where it swings out of the plane.
    """

    mass: Annotated[float, Field("kg", "mass m of the body", above=0)]
    centre_distance: Annotated[
        float, Field("m", "distance c from the hinge to the body's centre of gravity", at_least=1e-6)
    ]
    moment_of_inertia: Annotated[
        float,
        Field("kg m^2", "moment of inertia J about its centre of gravity", "a point", at_least=0),
    ] = 0.0
    damping: Annotated[float, Field("N m s/rad", "damping b of the hinge", "0: none", at_least=0)] = 0.0
    start_angle: Annotated[float, Field("rad", "angle at the start", "0: hanging")] = 0.0
    gravity: Annotated[float, Field("m/s^2", "acceleration g of free fall", CHOSEN)] = GRAVITY

    def check_on(self, mechanism: Mechanism) -> None:
        """Refuse a mechanism without a tip.

        Raises:
            ParameterError: it has none.
        """
        if not hasattr(mechanism, "tip"):
            raise ParameterError(
                "mechanism", type(mechanism).__name__, "has no tip(position), which a SwingingLoad hangs on"
            )

    def init(self) -> SwingingLoadState:
        return SwingingLoadState(self.start_angle, 0.0)

    def inertia(self, s: SwingingLoadState, mechanism: Any, position: float) -> float:
        tip = mechanism.tip(position)
        carried = self.mass * (tip.across * tip.across + tip.up * tip.up)
        return float(mechanism.inertia(position) + (carried - self.coupling(s, tip) * self.share(s, tip)))

    def resistance(self, s: SwingingLoadState, mechanism: Any, position: float, velocity: float) -> float:
        tip = mechanism.tip(position)
        bending = tip.across * tip.across_slope + tip.up * tip.up_slope
        inwards = tip.up * ops.cos(s.angle) - tip.across * ops.sin(s.angle)
        pull = bending * velocity * velocity + self.centre_distance * inwards * s.rate * s.rate
        met = self.mass * (pull + self.gravity * tip.up) - tip.turn * self.friction(s, tip, velocity)
        own = mechanism.resistance(position, velocity)
        return float(own + (met - self.share(s, tip) * self.torque(s, tip, velocity)))

    def deriv(
        self, s: SwingingLoadState, mechanism: Any, position: float, velocity: float, acceleration: float
    ) -> SwingingLoadState:
        tip = mechanism.tip(position)
        torque = self.torque(s, tip, velocity) + self.coupling(s, tip) * acceleration
        return SwingingLoadState(s.rate, -torque / self.hinge_inertia())

    def hinge_inertia(self) -> float:
        """I [kg m^2]."""
        return self.moment_of_inertia + self.mass * self.centre_distance * self.centre_distance

    def coupling(self, s: SwingingLoadState, tip: Tip) -> float:
        """M_xq, what the rod's acceleration turns the body by, m c P'.t [kg m]."""
        along = tip.across * ops.cos(s.angle) + tip.up * ops.sin(s.angle)
        return self.mass * self.centre_distance * along

    def share(self, s: SwingingLoadState, tip: Tip) -> float:
        """M_xq/M_qq, how much of a torque at the hinge the rod is spared [1/m]."""
        return self.coupling(s, tip) / self.hinge_inertia()

    def torque(self, s: SwingingLoadState, tip: Tip, velocity: float) -> float:
        """R_q, what turns the body back at an evenly moving rod [N m]."""
        slope = tip.across_slope * ops.cos(s.angle) + tip.up_slope * ops.sin(s.angle)
        lifted = slope * velocity * velocity + self.gravity * ops.sin(s.angle)
        return self.mass * self.centre_distance * lifted + self.friction(s, tip, velocity)

    def friction(self, s: SwingingLoadState, tip: Tip, velocity: float) -> float:
        """T [N m]."""
        return self.damping * (s.rate - tip.turn * velocity)
