"""Tones that a loop is excited with: at its command, its demand or its load."""

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo import ops
from hydroservo.block import Block, Field
from hydroservo.roles import Controller, Load, Reference, role
from hydroservo.signals import Demand, Measurement

__all__ = ["Excited", "ExcitedState", "PushedLoad", "Tones", "TonesAround"]


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


@role(Reference)
class TonesAround(NamedTuple):
    """A demand that grows evenly, and tones on it.

    Source: a definition.
    Fails as Tones do.
    """

    tones: Tones
    value: Annotated[float, Field("y", "demand at t = 0")]
    rate: Annotated[float, Field("y/s", "its rate")] = 0.0

    def at(self, t: float) -> Demand:
        r = self.tones.at(t)
        return Demand(self.value + self.rate * t + r.value, self.rate + r.rate, r.second_rate)


@role(Load)
class PushedLoad(NamedTuple):
    """A constant force on the rod, and tones on it.

    Source: a definition.
    Fails as Tones do.
    """

    tones: Tones
    mean: Annotated[float, Field("N", "mean force")] = 0.0

    def force(self, t: float) -> float:
        return self.mean + self.tones.at(t).value

    def next_jump(self, t: float) -> float:
        return math.inf


class ExcitedState(NamedTuple):
    """What the machine is given, the instant of the next sample, and the state of the law."""

    u: Annotated[float, Field("V", "command given to the machine")]
    time: Annotated[float, Field("s", "instant of the next sample")]
    controller: Block


@role(Controller)
class Excited(NamedTuple):
    """A law to whose command tones are added, of which it is told nothing.

    Source: Pintelon and Schoukens, System Identification, 2012, ch. 2 (identification in a loop).
    Fails where the law knows the applied command by other means than being told.
    """

    controller: Controller
    tones: Tones
    share: Annotated[float, Field("", "of a sample period, by which commands come late", at_least=0)] = 0.0

    def init(self) -> ExcitedState:
        return ExcitedState(0.0, 0.0, self.controller.init())

    def step(self, s: ExcitedState, y: Measurement, r: Demand, dt: float) -> ExcitedState:
        before, last = self.tones.at(s.time - 2.0 * dt).value, self.tones.at(s.time - dt).value
        told = y.with_command(y.command - (self.share * before + (1.0 - self.share) * last))
        law = self.controller.step(s.controller, told, r, dt)
        return ExcitedState(law.u + self.tones.at(s.time).value, s.time + dt, law)
