"""The derivatives of a loop's parts, of which every linear model of it is put together."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, values
from hydroservo.core.errors import ParameterError
from hydroservo.core.signals import MachineOutputs
from hydroservo.core.states import filled
from hydroservo.linear.operating_point import DigitalState, OperatingPoint, sampled
from hydroservo.linear.slopes import Slopes, slopes
from hydroservo.runs.steady import SIZES, sized

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]

FORCE = SIZES["N"]
STEEPEST = 1e100


class Parts(NamedTuple):
    """Derivatives, with x the machine's states, w the digital ones, r the demand and F the force on the rod.

    Attributes:
        machine: of dx/dt, and of what is seen and controlled, by [x, command, F].
        digital: of w after a sample by [x, w, r, F].
        held: of [hold's state, the commands between jumps] by [hold's state, last command, command].
    """

    machine: Matrix
    digital: Matrix
    held: Matrix


def parts_of(point: OperatingPoint) -> tuple[Parts, Slopes, Slopes]:
    """The derivatives of a loop's parts, and those of machine and digital side with what they may be off."""
    machine, digital = machine_slopes(point), digital_slopes(point)
    return Parts(machine.mean, digital.mean, held_slopes(point).mean), machine, digital


def machine_slopes(point: OperatingPoint) -> Slopes:
    """Of the machine's rates, of what is seen of it and of what is controlled, by [x, command, F]."""
    numbers = np.array([*values(point.machine), point.command, point.force])
    found = slopes(machine_rows, point, numbers, sizes(point.machine, 1.0, FORCE))
    steepest = np.abs(found.mean).max(initial=0.0)
    if not steepest < STEEPEST:
        problem = f"has slopes up to {steepest:.3g} in SI units, too steep for a linear model"
        if np.isnan(steepest):
            problem = "has no slope about its operating point: a number is lost near it"
        raise ParameterError("plant", type(point.loop.plant).__name__, problem)
    return found


def machine_rows(point: OperatingPoint, numbers: Sequence[Any]) -> list[Any]:
    left = iter(numbers)
    x, u, force = filled(point.machine, left), next(left), next(left)
    seen: MachineOutputs = point.loop.seen(x, force)
    return [*values(point.loop.rates(x, u, force)), *values(seen), point.loop.controls.of(seen, u)]


def digital_slopes(point: OperatingPoint) -> Slopes:
    numbers = [*values(point.machine), *values(point.digital), *values(point.demand), point.force]
    scale = [sizes(point.machine), sizes(point.digital), demand_sizes(point), np.array([FORCE])]
    return slopes(digital_rows, point, np.array(numbers), np.concatenate(scale))


def digital_rows(point: OperatingPoint, numbers: Sequence[Any]) -> list[Any]:
    left = iter(numbers)
    machine: Any = filled(point.machine, left)
    digital: DigitalState = filled(point.digital, left)
    demand: Any = filled(point.demand, left)
    return values(sampled(point._replace(force=next(left)), machine, digital, demand))


def law_slopes(point: OperatingPoint) -> Slopes:
    """Of the law's state after a sample, by [that before, what it measures, r]."""
    loop, dt = point.loop, point.loop.simulation.period
    seen = loop.seen(point.machine, point.force)
    y = loop.sensors.measure(point.digital.sensors, seen, point.command)
    law = point.digital.controller
    numbers = np.array([*values(law), *values(y), *values(point.demand)])
    scale = np.concatenate([sizes(law), sizes(y), demand_sizes(point)])

    def rows(controller: Block, numbers: Sequence[Any]) -> list[Any]:
        left = iter(numbers)
        return values(controller.step(filled(law, left), filled(y, left), filled(point.demand, left), dt))

    return slopes(rows, loop.controller, numbers, scale)


def held_slopes(point: OperatingPoint) -> Slopes:
    def rows(hold: Block, numbers: Sequence[Any]) -> list[Any]:
        *inner, last, u = numbers
        after = hold.step(filled(point.digital.hold, iter(inner)), last, 0.0)
        held = hold.held(after, u)
        return [*values(after), *(hold.at(held, t) for t in jumps(point)[:-1])]

    numbers = np.array([*values(point.digital.hold), point.command, point.command])
    return slopes(rows, point.loop.hold, numbers, sizes(point.digital.hold, 1.0, 1.0))


def sizes(state: Block, *others: float) -> Vector:
    """Of each number of a state, and of others; 1 for what is not measured."""
    found: Vector = np.nan_to_num(np.array([*(size for _, size in sized(state)), *others]), nan=1.0)
    return found


def demand_sizes(point: OperatingPoint) -> Vector:
    """Of the demand and its derivatives."""
    value = max(abs(point.demand.value), {"N": 1e3, "Pa": 1e6}.get(point.loop.controls.declared().unit, 0.1))
    return np.array([value, max(value, abs(point.demand.rate)), value])


def jumps(point: OperatingPoint) -> list[float]:
    """The instants of a sample period between which the command is constant, 0 and the period among them."""
    hold, period = point.loop.hold, point.loop.simulation.period
    held = hold.held(hold.step(point.digital.hold, point.command, 0.0), point.command)
    found = [0.0]
    while (jump := hold.next_jump(held, found[-1])) < period * (1.0 - 1e-9):
        found.append(jump)
    return [*found, period]
