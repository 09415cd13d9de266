"""What the runs of an audit are heard by: lumped disturbances, peaks of a command, and tones in it."""

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, at_samples, role
from hydroservo.machine.plants.design_model import DesignModel

TURNS = 25.0  # time constants in a window, of the mean about which a command swings

SHARE = 1e-3  # of the command's limit, beyond which a swing is chatter
TREND = 5  # degree of the polynomial that is taken for what the demand asks


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


class ToneAnswerState(NamedTuple):
    """Sums over the window so far, weighed by Hann's window, and what the command swings about."""

    weight: float
    c: float
    s: float
    cc: float
    cs: float
    ss: float
    u: float
    uc: float
    us: float
    lowest: float
    highest: float
    started: float
    slow: float
    above: float
    crossings: float


class ToneAnswerValues(NamedTuple):
    """What it comes to; nan where the run ended before."""

    real: Annotated[float, Field("V", "part of the law's command in phase with the tone")]
    imaginary: Annotated[float, Field("V", "part a quarter of a period ahead of it")]
    swing: Annotated[float, Field("V", "half the range of the law's command about its slow mean")]
    crossings: Annotated[float, Field("", "how often it crossed that")]


@role(Monitor)
@at_samples
class ToneAnswer(NamedTuple):
    """The fundamental of what an ``OpenedLaw`` asks for, by weighed least squares over a window.

    u_law = u_0 + Re(U e^(j w t)),  0 <= t - begin < window, weighed by sin^2(pi (t - begin)/window)

    Source: the definition of the describing function, U/A.
    Fails for a window of less than some three periods.
    """

    begin: Annotated[float, Field("s", "start of the window", at_least=0)]
    window: Annotated[float, Field("s", "its length", above=0)]

    def init(self) -> ToneAnswerState:
        nothing = ToneAnswerState(*[0.0] * len(ToneAnswerState._fields))
        return nothing._replace(lowest=math.inf, highest=-math.inf)

    def step(self, m: ToneAnswerState, loop: Block, s: Block, t: float, dt: float) -> ToneAnswerState:
        w, u = loop.controller.frequency, s.controller.controller.u
        c, q = ops.cos(w * t), ops.sin(w * t)
        now = t - self.begin
        inside = (now >= 0.0) & (now < self.window)
        root = ops.sin(math.pi * now / self.window)
        h = ops.where(inside, root * root, 0.0)
        slow = ops.where(m.started > 0.0, m.slow, u)
        slow = slow + dt * TURNS / self.window * (u - slow)
        left = u - slow
        side = ops.where(left > 0.0, 1.0, -1.0)
        crossed = inside & (m.above * side < 0.0)
        return ToneAnswerState(
            weight=m.weight + h,
            c=m.c + h * c,
            s=m.s + h * q,
            cc=m.cc + h * c * c,
            cs=m.cs + h * c * q,
            ss=m.ss + h * q * q,
            u=m.u + h * u,
            uc=m.uc + h * u * c,
            us=m.us + h * u * q,
            lowest=ops.where(inside, ops.minimum(left, m.lowest), m.lowest),
            highest=ops.where(inside, ops.maximum(left, m.highest), m.highest),
            started=1.0,
            slow=slow,
            above=ops.where(inside, side, 0.0),
            crossings=m.crossings + ops.where(crossed, 1.0, 0.0),
        )

    def values(self, m: ToneAnswerState) -> ToneAnswerValues:
        table = np.array([[m.weight, m.c, m.s], [m.c, m.cc, m.cs], [m.s, m.cs, m.ss]])
        right = np.array([m.u, m.uc, m.us])
        if not (np.isfinite(table).all() and np.isfinite(right).all()):
            return ToneAnswerValues(math.nan, math.nan, math.nan, math.nan)
        _, real, sine = np.linalg.lstsq(table, right, rcond=1e-6)[0].tolist()
        return ToneAnswerValues(real, -sine, 0.5 * (m.highest - m.lowest), m.crossings)


class Swing(NamedTuple):
    """How a command swings about its trend.

    Attributes:
        amplitude: half its range, without the hundredth part at either end [V].
        frequency: of the strongest line of its spectrum [rad/s].
    """

    amplitude: float
    frequency: float


def swing(command: ArrayLike, period: float) -> Swing:
    """The swing of a command over a window, less what a polynomial of degree five follows.

    A command chatters where the amplitude is above ``SHARE`` of its limit.

    Args:
        command: at the samples of the window [V].
        period: between them [s].

    Source: chosen here.
    Fails in a window in which the demand jumps: what follows the jump counts as a swing.
    """
    u = np.asarray(command, dtype=np.float64)
    if not np.isfinite(u).all():
        return Swing(math.nan, math.nan)
    x = np.linspace(-1.0, 1.0, len(u))
    left = u - np.polynomial.Polynomial.fit(x, u, TREND)(x)
    low, high = np.quantile(left, [0.01, 0.99])
    lines = np.abs(np.fft.rfft(left * np.hanning(len(u))))
    frequency = 2.0 * math.pi * float(np.argmax(lines)) / (len(u) * period)
    return Swing(0.5 * float(high - low), frequency)
