"""An axis as textbooks have it, of a loop as it is: its pair of poles, its velocity per command, its lags."""

import cmath
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.block import values
from hydroservo.core.errors import HydroservoError
from hydroservo.core.states import filled
from hydroservo.linear.linearization import Linearization
from hydroservo.linear.linearize import linearized
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.parts import sizes
from hydroservo.linear.slopes import slopes
from hydroservo.linear.system import System, response

LEAST_PART = 0.1  # of the piston's velocity in a pair of poles that is the axis's
FURTHER = 1.01  # times a command, for the slope of the velocity
SLOW = 1e-3  # of the natural frequency, below which nothing lags


class Axis(NamedTuple):
    """A machine where it moves: K_q omega^2/(s^2 + 2 zeta omega s + omega^2), and what lags in its loop.

    Attributes:
        natural_frequency: omega [rad/s].
        damping_ratio: zeta.
        velocity_gain: K_q, by which a little more command of the law raises the velocity [m/(s V)].
        stable_gain: the largest K_v of an integrator before it [1/s].
        velocity: of the piston [m/s].
        command: of the innermost law [V].
    """

    natural_frequency: float
    damping_ratio: float
    velocity_gain: float
    stable_gain: float
    velocity: float
    command: float


def axis_at(loop: Loop, command: float) -> Axis | None:
    """The axis about where a loop stays under a command [V]; None where it does not follow, or not swing.

    Its pair of poles is that of the machine in which the piston's velocity takes part most, by the
    participation factor: about half for a mass on its oil, and none for a valve.

    Source: Perez-Arriaga, Verghese, Schweppe, IEEE Transactions on Power Apparatus and Systems 101(9), 1982.
    Fails with several frequencies close to each other.
    """
    try:
        point, further = operating_point(loop, command), operating_point(loop, FURTHER * command)
        machine = linearized(point, "machine")
    except HydroservoError:
        return None
    velocity, asked = velocity_of(point), law_command(point)
    moved, more = velocity_of(further) - velocity, law_command(further) - asked
    pole = axis_pole(machine)
    if pole is None or not pole.real < 0.0 or not moved * more > 0.0:
        return None
    way = math.copysign(1.0, moved * command)
    gain = stable_gain(pole, lags(point, machine, pole, way))
    return Axis(abs(pole), -pole.real / abs(pole), moved / more, gain, velocity, asked)


def velocity_of(point: OperatingPoint) -> float:
    """The piston's velocity [m/s]."""
    return float(point.loop.seen(point.machine, point.force).velocity)


def law_command(point: OperatingPoint) -> float:
    """What the innermost law asks for [V]."""
    law: Any = point.digital.controller
    while hasattr(law, "controller"):
        law = law.controller
    return float(law.u)


def axis_pole(machine: Linearization) -> complex | None:
    """The pole of those that swing in which the velocity takes part most; None if it does in none."""
    from scipy.linalg import eig

    outputs = [one.name for one in machine.outputs]
    if "velocity" not in outputs:
        return None
    velocity = machine.C[outputs.index("velocity")]
    poles, left, right = eig(machine.A, left=True, right=True)
    with np.errstate(all="ignore"):
        parts = np.abs((velocity @ right) * (left.conj().T @ velocity) / np.sum(left.conj() * right, axis=0))
    parts = np.where((poles.imag > 0.0) & np.isfinite(parts), parts, 0.0)
    k = int(parts.argmax())
    return complex(poles[k]) if parts[k] > LEAST_PART else None


def stable_gain(pole: complex, lag: Callable[[float], float]) -> float:
    """The largest K_v [1/s] of an integrator before an axis, with and without a lag.

    2 zeta omega, or w/|G(j w)| at the frequency w where axis and lag come to 90 degrees, if that is less.

    Args:
        pole: of the axis [1/s].
        lag: of all else [rad], by the frequency [rad/s].
    """
    from scipy.optimize import brentq

    omega = abs(pole)

    def beyond(w: float) -> float:
        return lag(w) - cmath.phase(swing(pole, w)) - 0.5 * math.pi

    w = float(brentq(beyond, SLOW * omega, omega)) if beyond(SLOW * omega) < 0.0 else SLOW * omega
    return min(-2.0 * pole.real, w / abs(swing(pole, w)))


def swing(pole: complex, w: float) -> complex:
    """G = omega^2/(s^2 + 2 zeta omega s + omega^2) at a frequency [rad/s]."""
    return abs(pole) ** 2 / complex(abs(pole) ** 2 - w**2, -2.0 * pole.real * w)


def lags(
    point: OperatingPoint, machine: Linearization, pole: complex, way: float
) -> Callable[[float], float]:
    """What a loop lags by [rad], beside its axis and its law, at a frequency [rad/s].

    Args:
        point: where.
        machine: linearised there: what lags in it beside the axis is the valve.
        pole: of the axis [1/s].
        way: 1, or -1 where the velocity falls with the command.
    """
    sensors, loop = measuring(point), point.loop
    signal = np.array([1.0, 0.0] if loop.controls.declared().unit == "m/s" else [0.0, 1.0])
    held = loop.simulation.period * (1.5 - loop.hold.applied(loop.hold.init(), 1.0, loop.simulation.period))

    def lag(w: float) -> float:
        moved = complex(machine.response(w, "velocity", "command")[0])
        motion = np.array([1.0, 1.0 / (1j * w)])  # velocity and position
        measured = complex(response(sensors, np.array([w]))[0, 0] @ motion / (signal @ motion))
        return behind(way * moved / swing(pole, w)) + behind(measured) + w * held

    return lag


def behind(answer: complex) -> float:
    """The lag of an answer [rad], up to 270 degrees; 0 for one that leads."""
    return max((0.5 * math.pi - cmath.phase(answer)) % (2.0 * math.pi) - 0.5 * math.pi, 0.0)


def measuring(point: OperatingPoint) -> System:
    """The sensors from velocity and position to what they say of the controlled signal."""
    period, count = point.loop.simulation.period, len(values(point.digital.sensors))
    seen = point.loop.seen(point.machine, point.force)

    def rows(here: OperatingPoint, numbers: Sequence[Any]) -> list[Any]:
        left = iter(numbers)
        before: Any = filled(here.digital.sensors, left)
        there = seen._replace(velocity=next(left), position=next(left))
        after = here.loop.sensors.step(before, there, here.loop.draws(0.0, period), period)
        y = here.loop.sensors.measure(after, there, here.command)
        return [*values(after), here.loop.controls.of(y, here.command)]

    numbers = np.array([*values(point.digital.sensors), seen.velocity, seen.position])
    table = slopes(rows, point, numbers, sizes(point.digital.sensors, 0.1, 0.1)).mean
    (a, b), (c, d) = ((part[:, :count], part[:, count:]) for part in (table[:count], table[count:]))
    return System(a, b, c, d, period)
