"""A workpiece that the rod meets on its way out."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Mechanism, role
from hydroservo.core.signals import Tip


@role(Mechanism)
class Contact(NamedTuple):
    """A mechanism whose rod meets a workpiece at a position, presses it, and leaves it again.

    F_c = k_c d (1 + c v), not below 0,  d = x - x_c where that is above 0, else 0

    The force adds to the mechanism's resistance, so that a load cell at the rod shows it. It begins and ends
    at 0 without a jump, and never pulls. Pressed with F, the contact damps as b = c F.

    Source: Hunt and Crossley, Journal of Applied Mechanics 42(2), 1975, with exponent 1 for flat faces.
    Fails where the workpiece yields and stays deformed, moves by itself, or has a mass that counts.
    """

    mechanism: Mechanism
    position: Annotated[float, Field("m", "position x_c of the rod where contact begins", at_least=0)]
    stiffness: Annotated[float, Field("N/m", "stiffness k_c of workpiece and frame", above=0)]
    dissipation: Annotated[float, Field("s/m", "contact dissipation c", "0: elastic", at_least=0)] = 0.0

    def check(self) -> None:
        if not hasattr(self.mechanism, "tip"):
            raise ParameterError(
                "mechanism", type(self.mechanism).__name__, "must have a method tip(position)"
            )

    def check_within(self, start_position: float, stroke: float) -> None:
        """Refuse a workpiece behind the start position or beyond the stroke.

        Args:
            start_position: of the piston [m].
            stroke: of the piston [m].

        Raises:
            ParameterError: it is.
        """
        if not start_position <= self.position < stroke:
            allowed = f"must be from the start, {start_position:g} [m], to below the stroke, {stroke:g} [m]"
            raise ParameterError("mechanism.position", self.position, allowed)
        if hasattr(self.mechanism, "check_within"):
            self.mechanism.check_within(start_position, stroke)

    def positions(self) -> tuple[float, float]:
        of_mechanism = getattr(self.mechanism, "positions", None)
        return (-math.inf, math.inf) if of_mechanism is None else of_mechanism()

    def inertia(self, position: float) -> float:
        return self.mechanism.inertia(position)

    def resistance(self, position: float, velocity: float) -> float:
        depth = ops.maximum(position - self.position, 0.0)
        contact = self.stiffness * depth * ops.maximum(1.0 + self.dissipation * velocity, 0.0)
        return self.mechanism.resistance(position, velocity) + contact

    def tip(self, position: float) -> Tip:
        return self.mechanism.tip(position)  # type: ignore[attr-defined, no-any-return]
