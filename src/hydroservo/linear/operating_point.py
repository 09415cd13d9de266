"""Where a loop stays: its machine settled under a command, and its law asking for just that command."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop, MachineState
from hydroservo.core.block import Block, values
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import smoothed
from hydroservo.core.signals import Demand
from hydroservo.core.states import axpy, filled
from hydroservo.cosimulation import refuse_fmus
from hydroservo.linear.slopes import Function, central_slopes, difference_slopes, reachable_states
from hydroservo.machine.loads import Constant
from hydroservo.machine.starts import Steady
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.steady import state_sizes

Vector = NDArray[np.float64]

SAMPLES = 20  # after which filters and estimates have begun
SETTLED = 1e-7  # of each number's size, and of a volt
EXACT = 1e-14  # and nothing is left to gain
STEPS = 12  # of Newton's method, at most


class DigitalState(NamedTuple):
    """The states of all that is sampled."""

    sensors: Block
    controller: Block
    hold: Block


class OperatingPoint(NamedTuple):
    """Where a loop stays."""

    loop: Loop  # as it runs, its law designed
    command: float  # u [V]
    machine: MachineState  # its state
    digital: DigitalState  # that of sensors, law and hold
    demand: Demand  # under which the law asks for that command
    force: float  # on the rod [N]


def operating_point(loop: Loop, command: float | None, force: float | None = None) -> OperatingPoint:
    """Where a loop stays under a command and a load.

    The machine is in its steady state, and nothing counts in steps. The law is where it asks for the command
    sample after sample, with nothing in it that gathers speed, under a demand that grows as what is
    controlled does.

    Without a command [V] it is that of the loop's steady start, or 0; without a force [N], the load at t = 0.
    """
    return settle_law(machine_point(loop, command, force))


def machine_point(loop: Loop, command: float | None, force: float | None = None) -> OperatingPoint:
    """Where a machine stays under a command and a load, its law as it begins."""
    refuse_fmus(loop, "linearise it")
    loop = loop if force is None else loop._replace(load=Constant(force))
    start = loop.start if isinstance(loop.start, Steady) else Steady()
    asked: Steady = start if command is None else start._replace(command=command)
    started = runnable_loop(loop._replace(start=asked))
    u = float(asked.command)
    started = started._replace(controller=smoothed(started.controller), sensors=smoothed(started.sensors))
    machine = started.machine(started.init())
    acting = started.load.force(0.0)
    demand = fulfilled_demand(started, machine, u, acting)
    s = started.init()
    digital = DigitalState(s.sensors, s.controller, s.hold)
    return OperatingPoint(started, u, started.machine(s), digital, demand, acting)


def fulfilled_demand(loop: Loop, machine: MachineState, u: float, force: float) -> Demand:
    """The demand that the machine fulfils: its controlled signal, and the rate of that."""
    nudge = 1e-6
    rates = loop.rates(machine, u, force)
    ahead = axpy(machine, nudge, rates)
    now, later = (loop.controls.of(loop.seen(x, force), u) for x in (machine, ahead))
    return Demand(now, (later - now) / nudge, 0.0)


def digital_sample(
    point: OperatingPoint, machine: MachineState, digital: DigitalState, demand: Demand
) -> DigitalState:
    """Measure and run the controller at a sample, as :meth:`~hydroservo.control.loop.Loop.sample` does."""
    loop, dt = point.loop, point.loop.simulation.period
    seen = loop.seen(machine, point.force)
    sensors = loop.sensors.step(digital.sensors, seen, loop.draws(0.0, dt), dt)
    applied = loop.hold.applied(digital.hold, digital.controller.u, dt)
    y = loop.sensors.measure(sensors, seen, applied)
    hold = loop.hold.step(digital.hold, digital.controller.u, 0.0)
    return DigitalState(sensors, loop.controller.step(digital.controller, y, demand, dt), hold)


@np.errstate(all="ignore")  # what is lost does not settle
def settle_law(point: OperatingPoint) -> OperatingPoint:
    """A machine's point with the law where it stays."""
    rates = values(point.loop.rates(point.machine, point.command, point.force))
    drift = np.array(rates) * point.loop.simulation.period  # over a sample

    def later(count: int) -> tuple[MachineState, float]:
        """The machine some samples on, and what the demand has grown by."""
        moved = np.array(values(point.machine)) + count * drift
        grown = count * point.loop.simulation.period * point.demand.rate
        return filled(point.machine, iter(moved.tolist())), grown

    def run(digital: DigitalState, value: float, first: int, last: int) -> Iterator[DigitalState]:
        for count in range(first, last):
            machine, grown = later(count)
            digital = digital_sample(point, machine, digital, point.demand._replace(value=value + grown))
            yield digital

    *_, begun = run(point.digital, point.demand.value, -SAMPLES, 0)
    start = np.array([*values(begun), point.demand.value])
    sizes = np.array([*(size for _, size in state_sizes(begun)), max(abs(point.demand.value), 0.1)])
    free = np.isfinite(start) & moved_states(point._replace(digital=begun), sizes)

    def at(x: Vector) -> tuple[DigitalState, float]:
        numbers = start.copy()
        numbers[free] += sizes[free] * x
        *states, value = numbers.tolist()
        return filled(begun, iter(states)), value

    def unrest(x: Vector) -> Vector:
        digital, value = at(x)
        course = [digital, *run(digital, value, 0, 3)]
        speeding = np.diff([values(one) for one in course], 2, axis=0) / sizes[:-1]
        missing = np.array([one.controller.u for one in course[:-1]]) - point.command
        return np.asarray(np.nan_to_num(np.concatenate([speeding[:, free[:-1]].ravel(), missing]), nan=1e9))

    x = rest_of(unrest, np.zeros(int(free.sum())))
    if not np.abs(unrest(x)).max() < SETTLED:
        law = type(point.loop.controller).__name__
        problem = f"has no operating point under {point.command:g} V: what it asks for does not settle"
        raise ParameterError("controller", law, problem)
    digital, value = at(x)
    return point._replace(digital=digital, demand=point.demand._replace(value=value))


def rest_of(unrest: Function, x: Vector) -> Vector:
    """Where a function is 0, near x, or least among the places that Newton's method tries."""
    best, least = x, math.inf
    for _ in range(STEPS):
        missing = unrest(x)
        worst = float(np.abs(missing).max())
        if least < SETTLED and worst >= least:  # what is left is rounding
            break
        if worst < least:
            best, least = x, worst
        if least < EXACT:
            break
        slopes = central_slopes(unrest, missing, x, np.ones(len(x)))
        if not np.isfinite(slopes).all():
            break
        x = x - np.linalg.lstsq(slopes, missing)[0]
    return best


def moved_states(point: OperatingPoint, sizes: Vector) -> NDArray[np.bool_]:
    """Which of the digital states, and of the demand, the machine or the demand moves sooner or later.

    An integral that nothing feeds is to stay where it begins.
    """
    count = len(values(point.machine))

    def step(numbers: Vector) -> Vector:
        left = iter(numbers.tolist())
        machine: MachineState = filled(point.machine, left)
        digital: DigitalState = filled(point.digital, left)
        demand = point.demand._replace(value=next(left))
        return np.array(
            [*numbers[:count], *values(digital_sample(point, machine, digital, demand)), demand.value]
        )

    start = np.array([*values(point.machine), *values(point.digital), point.demand.value])
    scale = np.append([size for _, size in state_sizes(point.machine)], np.nan_to_num(sizes, nan=1.0))
    first = np.arange(len(start)) < count
    first[-1] = True
    return reachable_states(difference_slopes(step, start, scale).mean != 0.0, first)[count:]
