"""What a law makes of a tone: the part of its command at the tone's frequency."""

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, at_samples, role

TURNS = 25.0  # time constants in a window, of the mean about which a command swings

SHARE = 1e-3  # of the command's limit, beyond which a swing is chatter
TREND = 5  # degree of the polynomial that is taken for what the demand asks


class ToneState(NamedTuple):
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


class ToneValues(NamedTuple):
    """What it comes to; nan where the run ended before."""

    real: Annotated[float, Field("V", "part of the law's command in phase with the tone")]
    imaginary: Annotated[float, Field("V", "part a quarter of a period ahead of it")]
    swing: Annotated[float, Field("V", "half the range of the law's command about its slow mean")]
    crossings: Annotated[float, Field("", "how often it crossed that")]


@role(Monitor)
@at_samples
class Tone(NamedTuple):
    """The fundamental of what an :class:`Opened` law asks for, by weighed least squares over a window.

    u_law = u_0 + Re(U e^(j w t)),  0 <= t - begin < window, weighed by sin^2(pi (t - begin)/window)

    Source: the definition of the describing function, U/A.
    Fails for a window of less than some three periods.
    """

    begin: Annotated[float, Field("s", "start of the window", at_least=0)]
    window: Annotated[float, Field("s", "its length", above=0)]

    def init(self) -> ToneState:
        nothing = ToneState(*[0.0] * len(ToneState._fields))
        return nothing._replace(lowest=math.inf, highest=-math.inf)

    def step(self, m: ToneState, loop: Block, s: Block, t: float, dt: float) -> ToneState:
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
        return ToneState(
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

    def values(self, m: ToneState) -> ToneValues:
        table = np.array([[m.weight, m.c, m.s], [m.c, m.cc, m.cs], [m.s, m.cs, m.ss]])
        right = np.array([m.u, m.uc, m.us])
        if not (np.isfinite(table).all() and np.isfinite(right).all()):
            return ToneValues(math.nan, math.nan, math.nan, math.nan)
        _, real, sine = np.linalg.lstsq(table, right, rcond=1e-6)[0].tolist()
        return ToneValues(real, -sine, 0.5 * (m.highest - m.lowest), m.crossings)


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
