"""A valve's lag, as a law models it."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field

SHORTEST = 1e-30  # [s] in place of no time at all: what it keeps is 0


class Spool(NamedTuple):
    """A modelled spool at the end of a sample period, and what it was in the mean over it."""

    opening: Annotated[float, Field("V", "opening, as the command that would hold it")]
    mean: Annotated[float, Field("V", "mean opening, likewise")]


class SpoolLag(NamedTuple):
    """A spool of first order, its opening x in volts, under a command u held for a sample period.

    tau dx/dt = u - x, and with a = exp(-dt/tau)::

        x_k = u + a (x_(k-1) - u),   mean over the period  u + (1 - a) tau/dt (x_(k-1) - u)

    Source: the exact solution. Fails where the spool is of higher order or slew limited.
    """

    time_constant: Annotated[float, Field("s", "spool time constant tau; 0: no lag", at_least=0)]

    def under_held_command(self, opening: float, command: float, dt: float) -> Spool:
        """The spool after a period, from its opening at the start [V]."""
        return Spool(self.after(opening, command, dt), self.mean(opening, command, dt))

    def kept(self, dt: float) -> float:
        """Which share of its distance from the command is left after a time."""
        return ops.power(math.e, -dt / ops.maximum(self.time_constant, SHORTEST))

    def after(self, opening: float, command: float, dt: float) -> float:
        """The opening at the end of a period, from that at its start [V]."""
        return command + self.kept(dt) * (opening - command)

    def mean(self, opening: float, command: float, dt: float) -> float:
        """The mean opening over a period, from that at its start [V]."""
        return command + (opening - command) * (1.0 - self.kept(dt)) * self.time_constant / dt
