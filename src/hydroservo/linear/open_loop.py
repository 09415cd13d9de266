"""A loop opened at the command, for small motions: from what is given to the machine to what a law asks."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block, values
from hydroservo.linear.operating_point import DigitalState, OperatingPoint, sampled
from hydroservo.linear.slopes import Slopes, reached, slopes
from hydroservo.loop import MachineState
from hydroservo.runs.steady import sized
from hydroservo.states import filled

__all__ = ["OpenLoop", "Variants", "opened"]

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]


class OpenLoop(NamedTuple):
    """x_(k+1) = A x_k + B v_k, u_k = C x_k: v is given to the machine, u is what the law asks for.

    Attributes:
        a: A, shape (n, n).
        b: B, shape (n,).
        c: C, shape (n,).
        period: of the samples [s].
    """

    a: Matrix
    b: Vector
    c: Vector
    period: float

    def transfer(self, frequencies: Vector) -> NDArray[np.complex128]:
        """L = -C (z 1 - A)^-1 B, so that the closed loop has 1 + L, at some frequencies [rad/s]."""
        z = np.exp(1j * np.asarray(frequencies) * self.period)
        right = np.broadcast_to(self.b.astype(complex)[:, np.newaxis], (len(z), len(self.b), 1))
        x = np.linalg.solve(z[:, np.newaxis, np.newaxis] * np.eye(len(self.a)) - self.a, right)
        return np.asarray(-(x[..., 0] @ self.c), dtype=complex)

    def closed(self) -> Matrix:
        """A + B C, of the closed loop."""
        return self.a + np.outer(self.b, self.c)


class Variants(NamedTuple):
    """An open loop, and the same from other differences; see :class:`~hydroservo.linear.slopes.Slopes`.

    Attributes:
        loop: from central differences.
        of_machine: from other ones of the machine.
        of_digital: from other ones of sensors and law.
    """

    loop: OpenLoop
    of_machine: list[OpenLoop]
    of_digital: list[OpenLoop]


class Parts(NamedTuple):
    """Derivatives, of which a loop is put together, with x the machine's states and w the digital ones.

    Attributes:
        machine: of dx/dt by [x, command].
        digital: of w after a sample by [x, w].
        held: of [hold's state, the commands between jumps] by [hold's state, last command, command].
    """

    machine: Matrix
    digital: Matrix
    held: Matrix


def opened(point: OperatingPoint) -> Variants:
    """A loop about where it stays.

    The machine moves between samples as its rates, linearised, say exactly; sensors, law and hold step at
    samples. The loop is opened behind what the law is told of its own command.
    """
    machine, digital = machine_slopes(point), digital_slopes(point)
    parts, instants = Parts(machine.mean, digital.mean, held_slopes(point).mean), jumps(point)
    return Variants(
        put_together(point, parts, instants),
        [put_together(point, parts._replace(machine=one), instants) for one in machine.others],
        [put_together(point, parts._replace(digital=one), instants) for one in digital.others],
    )


def machine_slopes(point: OperatingPoint) -> Slopes:
    def rates(numbers: Vector) -> Vector:
        *x, u = numbers.tolist()
        return np.array(values(point.loop.rates(filled(point.machine, iter(x)), u, point.force)))

    return slopes(rates, np.array([*values(point.machine), point.command]), sizes(point.machine, 1.0))


def digital_slopes(point: OperatingPoint) -> Slopes:
    def step(numbers: Vector) -> Vector:
        left = iter(numbers.tolist())
        machine: MachineState = filled(point.machine, left)
        digital: DigitalState = filled(point.digital, left)
        return np.array(values(sampled(point, machine, digital, point.demand)))

    numbers = np.array([*values(point.machine), *values(point.digital)])
    return slopes(step, numbers, np.append(sizes(point.machine), sizes(point.digital)))


def held_slopes(point: OperatingPoint) -> Slopes:
    hold, instants = point.loop.hold, jumps(point)[:-1]

    def step(numbers: Vector) -> Vector:
        *inner, last, u = numbers.tolist()
        after = hold.step(filled(point.digital.hold, iter(inner)), last, 0.0)
        held = hold.held(after, u)
        return np.array([*values(after), *(hold.at(held, t) for t in instants)])

    numbers = np.array([*values(point.digital.hold), point.command, point.command])
    return slopes(step, numbers, sizes(point.digital.hold, 1.0, 1.0))


def sizes(state: Block, *others: float) -> Vector:
    """Of each number of a state, and of others; 1 for what is not measured."""
    found: Vector = np.nan_to_num(np.array([*(size for _, size in sized(state)), *others]), nan=1.0)
    return found


def jumps(point: OperatingPoint) -> list[float]:
    """The instants of a sample period between which the command is constant, 0 and the period among them."""
    hold, period = point.loop.hold, point.loop.simulation.period
    held = hold.held(hold.step(point.digital.hold, point.command, 0.0), point.command)
    found = [0.0]
    while (jump := hold.next_jump(held, found[-1])) < period * (1.0 - 1e-9):
        found.append(jump)
    return [*found, period]


def put_together(point: OperatingPoint, parts: Parts, instants: list[float]) -> OpenLoop:
    """The loop of its parts, in states [x, w, those of the machine's hold, the last command]."""
    n, m, k = (len(values(one)) for one in (point.machine, point.digital, point.digital.hold))
    x, w, h, last = slice(0, n), slice(n, n + m), slice(n + m, n + m + k), n + m + k
    a, b = np.zeros((last + 1, last + 1)), np.zeros(last + 1)
    scale = sizes(point.machine, 1.0)
    moved, driven = between(parts.machine * scale / scale[:n, np.newaxis], instants)
    a[x, x] = moved * scale[:n, np.newaxis] / scale[:n]
    commands = driven * scale[:n, np.newaxis] @ parts.held[k:]
    a[x, h], a[x, last], b[x] = commands[:, :k], commands[:, k], commands[:, k + 1]
    a[w, : n + m] = parts.digital
    a[h, h], a[h, last], b[h] = parts.held[:k, :k], parts.held[:k, k], parts.held[:k, k + 1]
    b[last] = 1.0
    order = np.array([*sizes(point.machine), *sizes(point.digital), *sizes(point.digital.hold), 1.0])
    asked = a[n + command_place(point.digital)]
    whole = OpenLoop(a * order / order[:, np.newaxis], b / order, asked * order, point.loop.simulation.period)
    return reduced(whole)


def between(table: Matrix, instants: list[float]) -> tuple[Matrix, Matrix]:
    """How a machine moves over a period: by its states, shape (n, n), and by each command, (n, commands).

    Args:
        table: its rates by [states, command].
        instants: between which the command is constant.
    """
    from scipy.linalg import expm

    n = len(table)
    whole = np.vstack([table, np.zeros(n + 1)])
    moved, driven = np.eye(n), np.zeros((n, 0))
    for start, end in pairwise(instants):
        one = expm((end - start) * whole)
        moved, driven = one[:n, :n] @ moved, np.column_stack([one[:n, :n] @ driven, one[:n, n]])
    return moved, driven


def command_place(digital: DigitalState) -> int:
    """Where the law's command is among the numbers of the digital states."""
    before = digital.controller._fields.index("u")
    return len(values(digital.sensors)) + len(values(digital.controller[:before]))


def reduced(loop: OpenLoop) -> OpenLoop:
    """Without the states that the machine's command does not reach, or from which the law's hears nothing."""
    links = loop.a != 0.0
    kept = reached(links, loop.b != 0.0) & reached(links.T, loop.c != 0.0)
    return OpenLoop(loop.a[np.ix_(kept, kept)], loop.b[kept], loop.c[kept], loop.period)
