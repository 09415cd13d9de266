"""A valve's lag, as a law models it."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field

__all__ = ["SpoolLag"]

SHORTEST = 1e-30  # [s] in place of no time at all: what it keeps is 0


class SpoolLag(NamedTuple):
    """A spool of first order, its opening x in volts, under a command u held for a sample period.

    tau dx/dt = u - x, so that x := u + exp(-dt/tau) (x - u).

    Source: the exact solution. Fails where the spool is of higher order or slew limited.
    """

    time_constant: Annotated[float, Field("s", "spool time constant tau; 0: no lag", at_least=0)]

    def after(self, opening: float, command: float, dt: float) -> float:
        """The opening at the end of a period [V]."""
        kept = ops.power(math.e, -dt / ops.maximum(self.time_constant, SHORTEST))
        return command + kept * (opening - command)

    def mean(self, before: float, after: float, command: float, dt: float) -> float:
        """The mean opening over a period, of which both ends are known [V]."""
        return command + (before - after) * self.time_constant / dt
