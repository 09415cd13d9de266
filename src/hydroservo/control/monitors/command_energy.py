"""The energy of the command and how often it is at its limit."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role
from hydroservo.core.sources import CHOSEN


class CommandEnergyState(NamedTuple):
    """Integrals so far."""

    squares: float
    limited: float  # [s]
    time: float  # [s]


class CommandEnergyValues(NamedTuple):
    """What it comes to."""

    control_energy: Annotated[
        float, Field("V^2 s", "integral of the command's square", smaller_is_better=True)
    ]
    saturation_share: Annotated[
        float, Field("", "share of the time with the command at its limit", smaller_is_better=True)
    ]


@role(Monitor)
class CommandEnergy(NamedTuple):
    """The integral of u^2 dt of the command as it acts at the valve, and the share of time it is at a limit.

    Source: a definition.
    Fails to know the limit of a law: it is given here.
    """

    limit: Annotated[float, Field("V", "size from which on a command is at its limit", CHOSEN, above=0)] = (
        10.0
    )

    def init(self) -> CommandEnergyState:
        return CommandEnergyState(0.0, 0.0, 0.0)

    def step(self, m: CommandEnergyState, loop: Block, s: Block, t: float, dt: float) -> CommandEnergyState:
        u = loop.hold.at(loop.held(s), t)
        limited = ops.where(ops.absolute(u) >= self.limit, dt, 0.0)
        return CommandEnergyState(m.squares + u * u * dt, m.limited + limited, m.time + dt)

    def values(self, m: CommandEnergyState) -> CommandEnergyValues:
        return CommandEnergyValues(m.squares, m.limited / m.time if m.time > 0.0 else math.nan)
