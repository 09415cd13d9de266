"""A square-wave velocity demand."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.signals import Demand

__all__ = ["Square"]

PAPER = "doi:10.1007/s42401-021-00087-w, Sec. 4"


class Square(NamedTuple):
    """offset +- amplitude, starting with +, half a period each; both derivatives are 0.

    Fails as a demand for laws that use its derivatives: the jumps are not in them.
    """

    amplitude: Annotated[float, Field("m/s", "amplitude", PAPER)] = 0.03
    period: Annotated[float, Field("s", "period", "that of the paper's sine", above=0)] = 4.0
    offset: Annotated[float, Field("m/s", "mean")] = 0.0

    def at(self, t: float) -> Demand:
        return Demand(self.offset + self.amplitude * ops.square_wave(t, self.period), 0.0, 0.0)
