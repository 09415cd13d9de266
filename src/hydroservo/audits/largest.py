"""The largest size of a signal over a run, with its instant, and those of the command."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Block
from hydroservo.field import Field
from hydroservo.roles import Monitor, at_samples, role


class Largest(NamedTuple):
    """The largest size of a signal so far, and when it was."""

    value: float
    time: float

    def heard(self, value: float, t: float, dt: float) -> "Largest":
        """After another value; the first period, in which a run starts from rest, does not count."""
        size = ops.absolute(value)
        grown = (size > self.value) & (t > 1.5 * dt)
        return Largest(ops.where(grown, size, self.value), ops.where(grown, t, self.time))


class CommandPeaksState(NamedTuple):
    """The command at the last sample, nan before the first, and what was largest."""

    u: float
    command: Largest
    command_rate: Largest


class CommandPeaksValues(NamedTuple):
    """What it comes to."""

    command: Annotated[float, Field("V", "largest command")]
    command_at: Annotated[float, Field("s", "when")]
    command_rate: Annotated[float, Field("V/s", "largest rate of the command")]
    command_rate_at: Annotated[float, Field("s", "when")]


@role(Monitor)
@at_samples
class CommandPeaks(NamedTuple):
    """The largest command and the largest rate of the command, from sample to sample.

    Fails: of a run that is lost it is what was largest before.
    """

    def init(self) -> CommandPeaksState:
        return CommandPeaksState(math.nan, Largest(0.0, 0.0), Largest(0.0, 0.0))

    def step(self, m: CommandPeaksState, loop: Block, s: Block, t: float, dt: float) -> CommandPeaksState:
        u, h = s.controller.u, loop.simulation.period
        return CommandPeaksState(u, m.command.heard(u, t, h), m.command_rate.heard((u - m.u) / h, t, h))

    def values(self, m: CommandPeaksState) -> CommandPeaksValues:
        return CommandPeaksValues(*m.command, *m.command_rate)
