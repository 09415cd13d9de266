"""A linear law as matrices: one that was designed elsewhere."""

from typing import Annotated, NamedTuple

from hydroservo.control.controlled.this_signal import THIS_SIGNAL
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core.block import Field
from hydroservo.core.roles import ControlledSignal, Controller, role
from hydroservo.core.signals import Demand, Measurement

Weight = Annotated[float, Field("", "weight, of SI numbers", "0: none")]


class StateWeights(NamedTuple):
    """A weight for each of eight states."""

    x1: Weight = 0.0
    x2: Weight = 0.0
    x3: Weight = 0.0
    x4: Weight = 0.0
    x5: Weight = 0.0
    x6: Weight = 0.0
    x7: Weight = 0.0
    x8: Weight = 0.0

    def of(self, x: "StateSpaceState") -> float:
        """The weighted sum of the states."""
        first = self.x1 * x.x1 + self.x2 * x.x2 + self.x3 * x.x3 + self.x4 * x.x4
        return first + self.x5 * x.x5 + self.x6 * x.x6 + self.x7 * x.x7 + self.x8 * x.x8


class StateWeightsOfEach(NamedTuple):
    """For each state after a sample, how much of each state before it is in it: the rows of A."""

    x1: StateWeights = StateWeights()
    x2: StateWeights = StateWeights()
    x3: StateWeights = StateWeights()
    x4: StateWeights = StateWeights()
    x5: StateWeights = StateWeights()
    x6: StateWeights = StateWeights()
    x7: StateWeights = StateWeights()
    x8: StateWeights = StateWeights()


class Weights(NamedTuple):
    """How much of an input is in each state after a sample, and in the command: a column of B and D."""

    states: StateWeights = StateWeights()
    command: Weight = 0.0


class MeasuredInput(NamedTuple):
    """A measured signal, and how much of it is in each state after a sample, and in the command."""

    signal: ControlledSignal = THIS_SIGNAL
    states: StateWeights = StateWeights()
    command: Weight = 0.0


class StateSpaceState(NamedTuple):
    """The command, and eight states."""

    u: Annotated[float, Field("V", "command")]
    x1: Annotated[float, Field("", "state 1 of the law")]
    x2: Annotated[float, Field("", "state 2 of the law")]
    x3: Annotated[float, Field("", "state 3 of the law")]
    x4: Annotated[float, Field("", "state 4 of the law")]
    x5: Annotated[float, Field("", "state 5 of the law")]
    x6: Annotated[float, Field("", "state 6 of the law")]
    x7: Annotated[float, Field("", "state 7 of the law")]
    x8: Annotated[float, Field("", "state 8 of the law")]


@role(Controller)
class StateSpace(NamedTuple):
    """Any linear law of up to eight states, three measured signals and the demand with its rates.

    With w = [r, r', r'', y_1, y_2, y_3], where each y is of the machine as the law measures it::

        u = sat(C x + D w),   x := A x + B w

    All weights are for SI numbers, and what is not given is 0. A law of a single gain has no state. It begins
    with its states at 0. :func:`hydroservo.interop.to_law` makes it of one from python-control.

    Source: Astrom and Wittenmark, Computer-Controlled Systems, 1997, ch. 4 (a law as a linear system).
    Fails at another sample period than the one that it was designed for; and where its command is limited,
    for then what integrates in it winds up: an AntiWindup does not reach into it.
    """

    a: StateWeightsOfEach = StateWeightsOfEach()
    c: StateWeights = StateWeights()
    demand: Weights = Weights()
    demand_rate: Weights = Weights()
    demand_second_rate: Weights = Weights()
    first: MeasuredInput = MeasuredInput()
    second: MeasuredInput = MeasuredInput()
    third: MeasuredInput = MeasuredInput()
    saturation: Saturation = Saturation()

    def init(self) -> StateSpaceState:
        return StateSpaceState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, s: StateSpaceState, y: Measurement, r: Demand, dt: float) -> StateSpaceState:
        y1 = self.first.signal.of(y, y.command)
        y2 = self.second.signal.of(y, y.command)
        y3 = self.third.signal.of(y, y.command)
        b1, b2, b3 = self.first.states, self.second.states, self.third.states
        told = self.told(r)
        u = self.c.of(s) + self.directly(r)
        u = u + self.first.command * y1 + self.second.command * y2 + self.third.command * y3
        a = self.a
        return StateSpaceState(
            self.saturation.apply(u),
            a.x1.of(s) + told.x1 + b1.x1 * y1 + b2.x1 * y2 + b3.x1 * y3,
            a.x2.of(s) + told.x2 + b1.x2 * y1 + b2.x2 * y2 + b3.x2 * y3,
            a.x3.of(s) + told.x3 + b1.x3 * y1 + b2.x3 * y2 + b3.x3 * y3,
            a.x4.of(s) + told.x4 + b1.x4 * y1 + b2.x4 * y2 + b3.x4 * y3,
            a.x5.of(s) + told.x5 + b1.x5 * y1 + b2.x5 * y2 + b3.x5 * y3,
            a.x6.of(s) + told.x6 + b1.x6 * y1 + b2.x6 * y2 + b3.x6 * y3,
            a.x7.of(s) + told.x7 + b1.x7 * y1 + b2.x7 * y2 + b3.x7 * y3,
            a.x8.of(s) + told.x8 + b1.x8 * y1 + b2.x8 * y2 + b3.x8 * y3,
        )

    def directly(self, r: Demand) -> float:
        """What the demand adds to the command [V]."""
        rates = self.demand_rate.command * r.rate + self.demand_second_rate.command * r.second_rate
        return self.demand.command * r.value + rates

    def told(self, r: Demand) -> StateWeights:
        """What the demand adds to each state."""
        b, b1, b2 = self.demand.states, self.demand_rate.states, self.demand_second_rate.states
        return StateWeights(
            b.x1 * r.value + b1.x1 * r.rate + b2.x1 * r.second_rate,
            b.x2 * r.value + b1.x2 * r.rate + b2.x2 * r.second_rate,
            b.x3 * r.value + b1.x3 * r.rate + b2.x3 * r.second_rate,
            b.x4 * r.value + b1.x4 * r.rate + b2.x4 * r.second_rate,
            b.x5 * r.value + b1.x5 * r.rate + b2.x5 * r.second_rate,
            b.x6 * r.value + b1.x6 * r.rate + b2.x6 * r.second_rate,
            b.x7 * r.value + b1.x7 * r.rate + b2.x7 * r.second_rate,
            b.x8 * r.value + b1.x8 * r.rate + b2.x8 * r.second_rate,
        )
