"""A demand and a load that go on from an instant of others."""

from typing import Annotated, NamedTuple

from hydroservo.block import Field
from hydroservo.roles import Load, Reference, role
from hydroservo.signals import Demand


@role(Reference)
class LaterDemand(NamedTuple):
    """A demand that begins where another is at an instant: r(t + t_0).

    Source: a definition.
    Fails where it is asked for an instant before 0.
    """

    reference: Reference
    begins: Annotated[float, Field("s", "the instant t_0", at_least=0)]

    def at(self, t: float) -> Demand:
        return self.reference.at(t + self.begins)


@role(Load)
class LaterLoad(NamedTuple):
    """A load that begins where another is at an instant: F(t + t_0).

    Source: a definition.
    Fails where it is asked for an instant before 0.
    """

    load: Load
    begins: Annotated[float, Field("s", "the instant t_0", at_least=0)]

    def force(self, t: float) -> float:
        return self.load.force(t + self.begins)

    def next_jump(self, t: float) -> float:
        return self.load.next_jump(t + self.begins) - self.begins
