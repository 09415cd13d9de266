"""A constant external force."""

from typing import Annotated, NamedTuple

from hydroservo.block import Field

__all__ = ["Constant"]

PAPER = "doi:10.1007/s42401-021-00087-w, Sec. 4"


class Constant(NamedTuple):
    """F_L = amplitude, from t = 0 on, positive against motion."""

    amplitude: Annotated[float, Field("N", "force", PAPER)] = 100.0

    def force(self, t: float) -> float:
        return self.amplitude
