"""A link on a hinge, raised by the cylinder."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.constants import GRAVITY
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Mechanism, role
from hydroservo.core.signals import Tip
from hydroservo.core.sources import CHOSEN

LEAST_SINE = 0.02  # of the hinge's angle: one degree off a dead point


@role(Mechanism)
class OneLinkArm(NamedTuple):
    """A one-link manipulator: hinge, cylinder base and rod pin form a triangle with sides l_b, l_p and l.

    The cylinder's length l = l_0 + x sets the angle q at the hinge, and with it the lever r::

        cos q = (l_b^2 + l_p^2 - l^2)/(2 l_b l_p),  r = dl/dq = l_b l_p sin(q)/l
        M(x) = m_p + J/r^2,                         J = J_arm + m_tip l_r^2
        M dv/dt = F - (1/2) dM/dx v^2 - G/r,        G = g (m_arm l_s + m_tip l_r) cos(q - q_0)

    q_0 is the angle q at which the link, through hinge, centre of gravity and tip, is level; a growing q
    raises it. X points from the hinge along the level link.

    Source: the cosine rule and Lagrange's equation for the coordinate x; the manipulator is the application
    of doi:10.1007/s42401-021-00087-w.
    Fails near the dead points, where hinge, base and pin lie on a line and the lever vanishes: sin q is
    held at 0.02 or more and l within its limits, which keeps numbers finite and is not the arm any more.
    The turning of the cylinder about its own base is neglected.
    """

    base_distance: Annotated[
        float, Field("m", "distance l_b from the hinge to the cylinder's base", at_least=1e-6)
    ]
    pin_distance: Annotated[float, Field("m", "distance l_p from the hinge to the rod's pin", at_least=1e-6)]
    closed_length: Annotated[float, Field("m", "distance l_0 from base to pin at position 0", at_least=1e-6)]
    level_angle: Annotated[float, Field("rad", "angle q_0 at the hinge where the link is level")]
    arm_inertia: Annotated[
        float, Field("kg m^2", "moment of inertia J_arm of the link about the hinge", above=0)
    ]
    arm_mass: Annotated[float, Field("kg", "mass m_arm of the link", at_least=0)]
    centre_distance: Annotated[
        float, Field("m", "distance l_s from the hinge to the link's centre of gravity")
    ]
    moving_mass: Annotated[float, Field("kg", "mass m_p of piston and rod", above=0)]
    payload: Annotated[float, Field("kg", "mass m_tip at the tip", "0: none", at_least=0)] = 0.0
    reach: Annotated[float, Field("m", "distance l_r from the hinge to the tip", "0: none", at_least=0)] = 0.0
    gravity: Annotated[float, Field("m/s^2", "acceleration g of free fall", CHOSEN)] = GRAVITY

    def check(self) -> None:
        least = self.arm_mass * self.centre_distance * self.centre_distance
        if not self.arm_inertia >= least:
            allowed = f"must be at least arm_mass centre_distance^2, {least:.4g} [kg m^2]"
            raise ParameterError("arm_inertia", self.arm_inertia, allowed)

    def positions(self) -> tuple[float, float]:
        """The least and the largest position in which the triangle closes, off its dead points [m]."""
        a, b = self.base_distance, self.pin_distance
        squares = a * a + b * b
        span = 2.0 * a * b * math.sqrt(1.0 - LEAST_SINE * LEAST_SINE)
        shortest, longest = math.sqrt(max(squares - span, 0.0)), math.sqrt(squares + span)
        return shortest - self.closed_length, longest - self.closed_length

    def inertia(self, position: float) -> float:
        length = self.length(position)
        lever = self.lever(length, self.sine(self.cosine(length)))
        return self.moving_mass + self.turning_inertia() / (lever * lever)

    def resistance(self, position: float, velocity: float) -> float:
        length = self.length(position)
        cosine = self.cosine(length)
        sine = self.sine(cosine)
        lever = self.lever(length, sine)
        lever_slope = self.lever_slope(length, lever, cosine, sine)
        half_slope = -self.turning_inertia() * lever_slope / (lever * lever * lever)  # (1/2) dM/dx
        return half_slope * velocity * velocity + self.gravity_torque(cosine, sine) / lever

    def length(self, position: float) -> float:
        """l, within what the triangle allows [m]."""
        longest = self.base_distance + self.pin_distance
        return ops.clip(self.closed_length + position, 1e-3 * self.closed_length, longest)

    def cosine(self, length: float) -> float:
        """cos q."""
        a, b = self.base_distance, self.pin_distance
        return ops.clip((a * a + b * b - length * length) * (1.0 / (2.0 * a * b)), -1.0, 1.0)

    def sine(self, cosine: float) -> float:
        """sin q, kept above its floor."""
        return ops.sqrt(ops.maximum(1.0 - cosine * cosine, LEAST_SINE * LEAST_SINE))

    def lever(self, length: float, sine: float) -> float:
        """r [m]."""
        return self.base_distance * self.pin_distance * sine / length

    def lever_slope(self, length: float, lever: float, cosine: float, sine: float) -> float:
        """dr/dx."""
        return cosine / sine - lever / length

    def tip(self, position: float) -> Tip:
        length = self.length(position)
        cosine = self.cosine(length)
        sine = self.sine(cosine)
        lever = self.lever(length, sine)
        turn = 1.0 / lever
        turn_slope = -self.lever_slope(length, lever, cosine, sine) * turn * turn
        across, up = self.reach * self.level(cosine, sine), self.reach * self.climb(cosine, sine)
        return Tip(
            -up * turn,
            across * turn,
            -across * turn * turn - up * turn_slope,
            across * turn_slope - up * turn * turn,
            turn,
        )

    def turning_inertia(self) -> float:
        """J [kg m^2]."""
        return self.arm_inertia + self.payload * self.reach * self.reach

    def gravity_torque(self, cosine: float, sine: float) -> float:
        """G [N m]."""
        weight = self.gravity * (self.arm_mass * self.centre_distance + self.payload * self.reach)
        return weight * self.level(cosine, sine)

    def level(self, cosine: float, sine: float) -> float:
        """cos(q - q_0)."""
        return cosine * ops.cos(self.level_angle) + sine * ops.sin(self.level_angle)

    def climb(self, cosine: float, sine: float) -> float:
        """sin(q - q_0)."""
        return sine * ops.cos(self.level_angle) - cosine * ops.sin(self.level_angle)
