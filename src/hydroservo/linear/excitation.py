"""What a loop is excited with, at its command, its demand or its load: tones, or a chirp."""

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, Load, Reference, role
from hydroservo.core.signals import Demand, Measurement

FADE = 0.025  # of a chirp's period, in which it comes, and in which it goes


class Tones(NamedTuple):
    """A sum of tones of one size, with its exact derivatives.

    r = amplitude sum_k sin(w_k t + phi_k)

    Source: Pintelon and Schoukens, System Identification, 2012, ch. 5 (random phase multisines).
    Fails as a start from rest: the first value is not 0.
    """

    amplitude: Annotated[float, Field("", "of each tone, in the unit of what is excited", at_least=0)]
    frequencies: Annotated[NDArray[np.float64], Field("rad/s", "w_k, shape (tones,)")]
    phases: Annotated[NDArray[np.float64], Field("rad", "phi_k, shape (tones,)")]

    def at(self, t: float) -> Demand:
        value = rate = second_rate = 0.0
        for i in range(self.frequencies.size):
            w = float(self.frequencies[i])
            angle = w * t + float(self.phases[i])
            value += self.amplitude * ops.sin(angle)
            rate += self.amplitude * w * ops.cos(angle)
            second_rate -= self.amplitude * w * w * ops.sin(angle)
        return Demand(value, rate, second_rate)


class ExcitationChirp(NamedTuple):
    """A tone that rises, each octave in the same time, and begins anew after a period T.

    r = amplitude w(t) sin(phi + 2 pi f_1 T/L (e^(L t/T) - 1)),   L = ln(f_2/f_1), with its derivatives

    with w from 0 to 1 and back to 0 as sin^2 in the first and last fortieth of the period, so that r and r'
    have no jump.

    Source: Pintelon and Schoukens, System Identification, 2012, ch. 5 (swept sines); Farina, 108th AES
    Convention, 2000 (the exponential sweep).
    Fails to excite single lines alone: there is power between them too, and a little beyond both ends.
    """

    amplitude: Annotated[float, Field("", "of the tone, in the unit of what is excited", at_least=0)]
    lowest: Annotated[float, Field("rad/s", "2 pi f_1", above=0)]
    growth: Annotated[float, Field("", "L, of the frequency over a period", above=0)]
    period: Annotated[float, Field("s", "T", above=0)]
    phase: Annotated[float, Field("rad", "phi")] = 0.0

    def at(self, t: float) -> Demand:
        left = t - self.period * ops.floor(t / self.period)
        rise = self.growth / self.period
        w = self.lowest * ops.power(math.e, rise * left)
        angle = self.phase + (w - self.lowest) / rise
        sine, cosine = ops.sin(angle), ops.cos(angle)
        pace = 0.5 * math.pi / (FADE * self.period)
        ahead = ops.minimum(left, self.period - left)
        fading = ops.where(ahead < FADE * self.period, 1.0, 0.0)
        turned = 2.0 * pace * ops.minimum(ahead, FADE * self.period)
        slope = fading * ops.where(left < 0.5 * self.period, pace, -pace) * ops.sin(turned)
        bend = fading * 2.0 * pace * pace * ops.cos(turned)
        share = 0.5 - 0.5 * ops.cos(turned)
        curving = (bend - share * w * w) * sine + (2.0 * slope * w + share * w * rise) * cosine
        return Demand(
            self.amplitude * share * sine,
            self.amplitude * (slope * sine + share * w * cosine),
            self.amplitude * curving,
        )


@role(Reference)
class ExcitedDemand(NamedTuple):
    """A demand that grows evenly, and an excitation on it.

    Source: a definition.
    Fails as Tones do.
    """

    excitation: Block
    value: Annotated[float, Field("y", "demand at t = 0")]
    rate: Annotated[float, Field("y/s", "its rate")] = 0.0

    def at(self, t: float) -> Demand:
        r = self.excitation.at(t)
        return Demand(self.value + self.rate * t + r.value, self.rate + r.rate, r.second_rate)


@role(Load)
class PushedLoad(NamedTuple):
    """A constant force on the rod, and an excitation on it.

    Source: a definition.
    Fails as Tones do.
    """

    excitation: Block
    mean: Annotated[float, Field("N", "mean force")] = 0.0

    def force(self, t: float) -> float:
        added: float = self.excitation.at(t).value
        return self.mean + added

    def next_jump(self, t: float) -> float:
        return math.inf


class ExcitedState(NamedTuple):
    """What the machine is given, the instant of the next sample, and the state of the law."""

    u: Annotated[float, Field("V", "command given to the machine")]
    time: Annotated[float, Field("s", "instant of the next sample")]
    controller: Block


@role(Controller)
class Excited(NamedTuple):
    """A law to whose command an excitation is added, of which it is told nothing.

    Source: Pintelon and Schoukens, System Identification, 2012, ch. 2 (identification in a loop).
    Fails where the law knows the applied command by other means than being told.
    """

    controller: Controller
    excitation: Block
    share: Annotated[float, Field("", "of a sample period, by which commands come late", at_least=0)] = 0.0

    def init(self) -> ExcitedState:
        return ExcitedState(0.0, 0.0, self.controller.init())

    def step(self, s: ExcitedState, y: Measurement, r: Demand, dt: float) -> ExcitedState:
        before = self.excitation.at(s.time - 2.0 * dt).value
        last = self.excitation.at(s.time - dt).value
        told = y.with_command(y.command - (self.share * before + (1.0 - self.share) * last))
        law = self.controller.step(s.controller, told, r, dt)
        return ExcitedState(law.u + self.excitation.at(s.time).value, s.time + dt, law)
