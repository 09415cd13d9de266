"""Effects that a machine may have, as small changes of its command and of the force on its rod."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Field
from hydroservo.identification.experiment import Experiment
from hydroservo.identification.log import COMMAND
from hydroservo.loop import Loop
from hydroservo.roles import Load
from hydroservo.runs.run import ready
from hydroservo.signals import Demand, Measurement

STILL = 0.01  # of the largest speed, below which friction changes sign smoothly
WIDTH = 0.02  # of the largest command, of a hysteresis and an overlap
AIR = 1e5  # Pa, about where air in the oil counts

Vector = NDArray[np.float64]


class Direction(NamedTuple):
    """An effect as a signal that drives the machine beside what was recorded.

    Attributes:
        name: of the effect.
        unit: of its amount; "" where that means nothing by itself.
        values: per amount of 1, shape (n,).
        positive: whether only an amount above 0 makes sense.
    """

    name: str
    unit: str
    values: Vector
    positive: bool


class DisturbedPlayback(NamedTuple):
    """u_k = recorded command + amount times one of several directions."""

    commands: Annotated[NDArray[np.float64], Field("V", "command at each sample, shape (samples,)")]
    directions: Annotated[NDArray[np.float64], Field("", "shape (directions, samples)")]
    which: Annotated[float, Field("", "number of the direction")] = 0.0
    amount: Annotated[float, Field("", "how much of it")] = 0.0

    def init(self) -> "DisturbedState":
        return DisturbedState(0.0, 0.0)

    def step(self, s: "DisturbedState", y: Measurement, r: Demand, dt: float) -> "DisturbedState":
        k = int(s.sample)
        u = float(self.commands[k]) + self.amount * float(self.directions[int(self.which), k])
        return DisturbedState(u, s.sample + 1.0)


class DisturbedState(NamedTuple):
    """The last command, and the number of the next one."""

    u: Annotated[float, Field("V", "command")]
    sample: Annotated[float, Field("", "samples so far")]


class DisturbedLoad(NamedTuple):
    """F(t) = force of a load + amount times one of several directions, held from sample to sample."""

    load: Load
    directions: Annotated[NDArray[np.float64], Field("", "shape (directions, samples)")]
    period: Annotated[float, Field("s", "between samples")]
    which: Annotated[float, Field("", "number of the direction")] = 0.0
    amount: Annotated[float, Field("", "how much of it")] = 0.0

    def force(self, t: float) -> float:
        k = int(t / self.period)
        return self.load.force(t) + self.amount * float(self.directions[int(self.which), k])

    def next_jump(self, t: float) -> float:
        return self.load.next_jump(t)


def disturbed(
    one: Experiment, machine: Loop, forces: Sequence[Direction], commands: Sequence[Direction]
) -> Experiment:
    """The experiment of a machine that takes a direction of force or command."""
    segment = one.segment
    law = DisturbedPlayback(
        np.ascontiguousarray(segment.inputs[COMMAND]), np.array([own.values for own in commands])
    )
    padded = np.array([np.append(own.values, own.values[-1]) for own in forces])
    given = machine._replace(
        controller=law,
        load=DisturbedLoad(machine.load, padded, segment.period),
    )
    varied = ("load.which", "load.amount", "controller.which", "controller.amount")
    return Experiment(segment, given, ready(given), {}, varied)


def force_directions(one: Experiment, shown: Mapping[str, Vector]) -> Iterator[Direction]:
    """Forces on the rod, positive against motion, per unit of their amount."""
    speed, position = shown["velocity"], shown["position"]
    time = one.segment.time - one.segment.start
    still = STILL * max(float(np.abs(speed).max()), 1e-9)
    yield Direction("dry friction", "N", np.tanh(speed / still), True)
    yield Direction("friction that differs by direction", "N", np.abs(np.tanh(speed / still)), False)
    yield Direction("viscous friction", "N s/m", speed, True)
    yield Direction("a constant force", "N", np.ones(speed.size), False)
    yield Direction("a force that drifts", "N/s", time - time.mean(), False)
    yield Direction("a spring", "N/m", position - position.mean(), False)


def command_directions(command: Vector, shown: Mapping[str, Vector], period: float) -> Iterator[Direction]:
    """Changes of the command as the valve would feel it, per unit of their amount."""
    largest = max(float(np.abs(command).max()), 1e-6)
    width = WIDTH * largest
    yield Direction("valve hysteresis", "V", (backlash(command, width) - command) / width, True)
    yield Direction("valve overlap", "V", -np.clip(command, -width, width) / width, True)
    yield Direction("a shift of the valve's null", "V", np.ones(command.size), False)
    yield Direction("a valve gain that differs by direction", "", np.abs(command), False)
    load = shown["load_force"]
    yield Direction("leakage", "", -load / max(float(np.abs(load).max()), 1.0), True)
    sides = [shown["pressure_a"], shown["pressure_b"]]
    rates = [np.gradient(side, period) / np.maximum(side + AIR, 0.1 * AIR) ** 2 for side in sides]
    air = rates[1] - rates[0]
    yield Direction("air in the oil", "", air / max(float(np.abs(air).max()), 1e-30), True)


def backlash(command: Vector, width: float) -> Vector:
    """A command through a backlash of a full width: the play operator."""
    played, at = np.empty(command.size), float(command[0])
    for k, value in enumerate(command.tolist()):
        at = min(max(at, value - 0.5 * width), value + 0.5 * width)
        played[k] = at
    return played


def scale_of(own: Direction) -> float:
    """The largest value of a direction."""
    return max(float(np.abs(own.values).max()), 1e-300)
