"""A constant external force."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Load, role


@role(Load)
class Constant(NamedTuple):
    """F_L = amplitude, from t = 0 on, positive against motion.

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w.
    Fails as a start in equilibrium of a LoadPressurePlant: at rest that carries no load yet, so the onset is
    a jump. A Cylinder whose start pressures are open holds it from the start.
    """

    amplitude: Annotated[float, Field("N", "force", "0: none")] = 0.0

    def force(self, t: float) -> float:
        return self.amplitude

    def next_jump(self, t: float) -> float:
        return math.inf
