"""The largest signals of a run and its lumped disturbances, each with its instant."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, at_samples, role
from hydroservo.machine.plants.design_model import DesignModel


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


class LumpedState(NamedTuple):
    """The disturbances at the last sample, and what was largest; nan before the first."""

    d1: float
    d2: float
    opened: float
    largest_1: Largest
    largest_2: Largest
    largest_opened: Largest
    rate_1: Largest
    rate_2: Largest
    rate_opened: Largest


class LumpedValues(NamedTuple):
    """What it comes to: six sizes, each with its instant [s]."""

    largest_1: Annotated[float, Field("m/s^2", "largest |d_L1|")]
    largest_1_at: Annotated[float, Field("s", "when")]
    largest_2: Annotated[float, Field("N/s", "largest |d_L2|, by the command")]
    largest_2_at: Annotated[float, Field("s", "when")]
    largest_opened: Annotated[float, Field("N/s", "largest |d_L2|, by the valve's opening")]
    largest_opened_at: Annotated[float, Field("s", "when")]
    rate_1: Annotated[float, Field("m/s^3", "largest rate of d_L1")]
    rate_1_at: Annotated[float, Field("s", "when")]
    rate_2: Annotated[float, Field("N/s^2", "largest rate of d_L2, by the command")]
    rate_2_at: Annotated[float, Field("s", "when")]
    rate_opened: Annotated[float, Field("N/s^2", "largest rate of d_L2, by the opening")]
    rate_opened_at: Annotated[float, Field("s", "when")]


@role(Monitor)
@at_samples
class Lumped(NamedTuple):
    """What the machine does besides a model, as an observer of it is asked to know.

    d_L1 = dx1/dt - f1(x1) - g1 x2,   d_L2 = dx2/dt - f2(x1, x2) - g2(x2, u) u

    with the machine's true rates at the samples; once more d_L2 with the valve's opening in volts in place of
    u. The first period, in which a run starts from rest, does not count.

    Source: eq. (6) of doi:10.1007/s42401-021-00087-w.
    Fails to tell a disturbance from chatter, which is in d_L2 by the command.
    """

    model: DesignModel
    gain: Annotated[float, Field("m/V", "opening of the valve per command", above=0)]

    def init(self) -> LumpedState:
        return LumpedState(math.nan, math.nan, math.nan, *[Largest(0.0, 0.0)] * 6)

    def step(self, m: LumpedState, loop: Block, s: Block, t: float, dt: float) -> LumpedState:
        held, machine, h = loop.held(s), loop.machine(s), loop.simulation.period
        u = loop.hold.at(held, t)
        rate = loop.deriv(t, machine, held).plant
        x1, x2 = s.plant.velocity, loop.plant.hydraulic_force(s.plant)
        d1 = rate.velocity - (self.model.f1(x1) + self.model.g1() * x2)
        free = loop.plant.hydraulic_force(rate) - self.model.f2(x1, x2)
        opening = loop.valve.opening(s.valve, u) / self.gain
        d2 = free - self.model.g2(x2, u) * u
        opened = free - self.model.g2(x2, opening) * opening
        return LumpedState(
            d1,
            d2,
            opened,
            m.largest_1.heard(d1, t, h),
            m.largest_2.heard(d2, t, h),
            m.largest_opened.heard(opened, t, h),
            m.rate_1.heard((d1 - m.d1) / h, t, h),
            m.rate_2.heard((d2 - m.d2) / h, t, h),
            m.rate_opened.heard((opened - m.opened) / h, t, h),
        )

    def values(self, m: LumpedState) -> LumpedValues:
        return LumpedValues(*(number for largest in m[3:] for number in largest))
