"""An FMU as the load of a loop."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.field import OPEN
from hydroservo.core.roles import Load, role
from hydroservo.core.sources import CHOSEN

STEP = Field("s", "communication step; automatic: the sample period", CHOSEN, above=0, auto=OPEN)
LOAD_INPUTS = {"position": "m", "velocity": "m/s"}
LOAD_OUTPUTS = {"force": "N"}


@role(Load)
class ForeignLoad(NamedTuple):
    """F_L = what an FMU answers to the rod's position and velocity, positive against motion.

    At each communication t_i it is given both, and answers F(t_i); that is held until t_(i+1), while the FMU
    steps there with its inputs held. Of a smooth force the hold is h/2 late on average, h the step, so that
    errors of the run are of the first order in h.

    Source: Kuebler and Schiehlen, Mathematical and Computer Modelling of Dynamical Systems 6(2), 2000
    (parallel exchange of held values).
    Fails with an FMU stiff enough to swing against the machine at that delay: a spring k gains k v^2 h/2 of
    power as a damper of -k h/2 would. One that answers its inputs only after a step is one step later still.
    """

    step: Annotated[float, STEP] = OPEN
    held: Annotated[float, Field("N", "force held until the next communication", "the FMU", derived=True)] = (
        0.0
    )

    def force(self, t: float) -> float:
        return self.held

    def next_jump(self, t: float) -> float:
        return math.inf
