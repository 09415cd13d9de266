"""The derivatives of a loop's parts, and the loop, opened at its command, that they make."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, values
from hydroservo.core.errors import ParameterError
from hydroservo.core.signals import MachineOutputs
from hydroservo.core.states import filled
from hydroservo.linear.operating_point import DigitalState, OperatingPoint, digital_sample
from hydroservo.linear.slopes import Slopes, reachable_states, slopes
from hydroservo.runs.steady import SIZES, state_sizes

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]

FORCE_SIZE = SIZES["N"]
STEEPEST = 1e100
Response = NDArray[np.complex128]

COMMAND = 0  # inputs: what is given to the machine, r, F
DEMAND = slice(1, 4)
FORCE = 4
ASKED = 0  # the first output: what the law asks for; then come what is seen, and what is controlled


class PartSlopes(NamedTuple):
    """Derivatives, with machine's states x, digital ones w, demand r and force on the rod F."""

    machine: Matrix  # of dx/dt, and of what is seen and controlled, by [x, command, F]
    digital: Matrix  # of w after a sample by [x, w, r, F]
    held: Matrix  # of [hold's state, the commands between jumps] by [hold's state, last command, command]


def part_slopes(point: OperatingPoint) -> tuple[PartSlopes, Slopes, Slopes]:
    """The derivatives of a loop's parts, and those of machine and digital side with what they may be off."""
    machine, digital = machine_slopes(point), digital_slopes(point)
    return PartSlopes(machine.mean, digital.mean, held_slopes(point).mean), machine, digital


def machine_slopes(point: OperatingPoint) -> Slopes:
    """Of the machine's rates, of what is seen of it and of what is controlled, by [x, command, F]."""
    numbers = np.array([*values(point.machine), point.command, point.force])
    found = slopes(machine_rows, point, numbers, size_vector(point.machine, 1.0, FORCE_SIZE))
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
    scale = [
        size_vector(point.machine),
        size_vector(point.digital),
        demand_sizes(point),
        np.array([FORCE_SIZE]),
    ]
    return slopes(digital_rows, point, np.array(numbers), np.concatenate(scale))


def digital_rows(point: OperatingPoint, numbers: Sequence[Any]) -> list[Any]:
    left = iter(numbers)
    machine: Any = filled(point.machine, left)
    digital: DigitalState = filled(point.digital, left)
    demand: Any = filled(point.demand, left)
    return values(digital_sample(point._replace(force=next(left)), machine, digital, demand))


def law_slopes(point: OperatingPoint) -> Slopes:
    """Of the law's state after a sample, by [that before, what it measures, r]."""
    loop, dt = point.loop, point.loop.simulation.period
    seen = loop.seen(point.machine, point.force)
    y = loop.sensors.measure(point.digital.sensors, seen, point.command)
    law = point.digital.controller
    numbers = np.array([*values(law), *values(y), *values(point.demand)])
    scale = np.concatenate([size_vector(law), size_vector(y), demand_sizes(point)])

    def rows(controller: Block, numbers: Sequence[Any]) -> list[Any]:
        left = iter(numbers)
        return values(controller.step(filled(law, left), filled(y, left), filled(point.demand, left), dt))

    return slopes(rows, loop.controller, numbers, scale)


def held_slopes(point: OperatingPoint) -> Slopes:
    def rows(hold: Block, numbers: Sequence[Any]) -> list[Any]:
        *inner, last, u = numbers
        after = hold.step(filled(point.digital.hold, iter(inner)), last, 0.0)
        held = hold.held(after, u)
        return [*values(after), *(hold.at(held, t) for t in command_jumps(point)[:-1])]

    numbers = np.array([*values(point.digital.hold), point.command, point.command])
    return slopes(rows, point.loop.hold, numbers, size_vector(point.digital.hold, 1.0, 1.0))


def size_vector(state: Block, *others: float) -> Vector:
    """Of each number of a state, and of others; 1 for what is not measured."""
    found: Vector = np.nan_to_num(np.array([*(size for _, size in state_sizes(state)), *others]), nan=1.0)
    return found


def demand_sizes(point: OperatingPoint) -> Vector:
    value = max(abs(point.demand.value), {"N": 1e3, "Pa": 1e6}.get(point.loop.controls.declared().unit, 0.1))
    return np.array([value, max(value, abs(point.demand.rate)), value])


def command_jumps(point: OperatingPoint) -> list[float]:
    """The instants of a sample period between which the command is constant, 0 and the period among them."""
    hold, period = point.loop.hold, point.loop.simulation.period
    held = hold.held(hold.step(point.digital.hold, point.command, 0.0), point.command)
    found = [0.0]
    while (jump := hold.next_jump(held, found[-1])) < period * (1.0 - 1e-9):
        found.append(jump)
    return [*found, period]


class System(NamedTuple):
    """x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k; of a period 0: dx/dt = A x + B u, y = C x + D u."""

    a: Matrix  # A, shape (n, n)
    b: Matrix  # B, shape (n, inputs)
    c: Matrix  # C, shape (outputs, n)
    d: Matrix  # D, shape (outputs, inputs)
    period: float  # of the samples [s]; 0 in continuous time

    def part(self, inputs: list[int], outputs: list[int]) -> "System":
        """The same with some of its inputs and outputs."""
        d = self.d[np.ix_(outputs, inputs)]
        return System(self.a, self.b[:, inputs], self.c[outputs], d, self.period)

    def kept(self, states: NDArray[np.bool_]) -> "System":
        """The same with some of its states, which the others do not move."""
        a = self.a[np.ix_(states, states)]
        return System(a, self.b[states], self.c[:, states], self.d, self.period)


@np.errstate(invalid="ignore")  # scipy reads a permutation, not asked for, from large scales
def frequency_response(
    system: System, frequencies: NDArray[np.float64], columns: Response | None = None
) -> Response:
    """G = C (z 1 - A)^-1 B + D at some frequencies [rad/s], shape (frequencies, outputs, inputs).

    z is e^(j w h), or j w in continuous time. Rows and columns are balanced before, for SI numbers go from
    micrometres to hundreds of bar.

    ``columns`` stand in place of B where that depends on the frequency, shape (frequencies, n, inputs).
    """
    from scipy.linalg import matrix_balance

    s = 1j * np.asarray(frequencies, dtype=np.float64)
    z = np.exp(s * system.period) if system.period else s
    if not len(system.a):
        return np.broadcast_to(system.d, (len(z), *system.d.shape)).astype(complex)
    balanced, (scale, _) = matrix_balance(system.a, permute=False, separate=True)
    b = (system.b if columns is None else columns) / scale[:, np.newaxis]
    right = np.broadcast_to(b.astype(complex), (len(z), *b.shape[-2:]))
    x = np.linalg.solve(z[:, np.newaxis, np.newaxis] * np.eye(len(balanced)) - balanced, right)
    return np.asarray((system.c * scale) @ x + system.d)


def force_effect(point: OperatingPoint, parts: PartSlopes, frequencies: NDArray[np.float64]) -> Response:
    """What a tone of the force adds to the machine's states over a sample, shape (frequencies, states).

    A load is no command: it goes on between samples. With F e^(j w t) that is, exactly,
    (j w 1 - A)^-1 (e^(j w h) 1 - e^(A h)) B_F.
    """
    from scipy.linalg import expm

    n, h = len(values(point.machine)), point.loop.simulation.period
    scale = size_vector(point.machine)
    a, b = parts.machine[:n, :n] * scale / scale[:, np.newaxis], parts.machine[:n, n + 1] / scale
    s = 1j * np.asarray(frequencies, dtype=np.float64)[:, np.newaxis, np.newaxis]
    moved = (np.exp(s * h) * np.eye(n) - expm(h * a)) @ b[:, np.newaxis]
    return np.asarray(np.linalg.solve(s * np.eye(n) - a, moved)[..., 0] * scale)


@np.errstate(all="ignore")  # what is lost is not finite, and refused as that
def opened_system(point: OperatingPoint, parts: PartSlopes) -> System:
    """A loop opened at its command, in states [x, w, those of the machine's hold, the last command].

    The machine moves between samples as its rates, linearised, say exactly, with the force held over a sample
    as the command is; sensors, law and hold step at samples. The loop is opened behind what the law is told
    of its own command.
    """
    n, m, k = (len(values(one)) for one in (point.machine, point.digital, point.digital.hold))
    x, w, h, last = slice(0, n), slice(n, n + m), slice(n + m, n + m + k), n + m + k
    a, b = np.zeros((last + 1, last + 1)), np.zeros((last + 1, 5))
    scale = size_vector(point.machine, 1.0, 1.0)
    moved, driven = motion_between(parts.machine[:n] * scale / scale[:n, np.newaxis], command_jumps(point))
    own = scale[:n, np.newaxis]
    a[x, x] = moved * own / scale[:n]
    commands = driven[:, :-1] * own @ parts.held[k:]
    a[x, h], a[x, last], b[x, COMMAND] = commands[:, :k], commands[:, k], commands[:, k + 1]
    b[x, FORCE] = driven[:, -1] * scale[:n]
    a[w, : n + m] = parts.digital[:, : n + m]
    b[w, DEMAND], b[w, FORCE] = parts.digital[:, n + m : n + m + 3], parts.digital[:, -1]
    a[h, h], a[h, last], b[h, COMMAND] = parts.held[:k, :k], parts.held[:k, k], parts.held[:k, k + 1]
    b[last, COMMAND] = 1.0
    seen = parts.machine[n:]
    c, d = np.zeros((1 + len(seen), last + 1)), np.zeros((1 + len(seen), 5))
    law = point.digital.controller
    before = law._fields.index("u")
    asked = n + len(values(point.digital.sensors)) + len(values(law[:before]))
    c[ASKED], d[ASKED] = a[asked], b[asked]
    c[1:, x], d[1:, COMMAND], d[1:, FORCE] = seen[:, :n], seen[:, n], seen[:, n + 1]
    return System(a, b, c, d, point.loop.simulation.period)


def motion_between(table: Matrix, instants: list[float]) -> tuple[Matrix, Matrix]:
    """How a machine moves over a period: by its states, shape (n, n), and by what drives it.

    The table has the rates by [states, command, force]; the command is constant between the instants. The
    second result has a column for each command, and the last one for the force.
    """
    from scipy.linalg import expm

    n = len(table)
    whole = np.vstack([table, np.zeros((2, n + 2))])
    moved, driven, pushed = np.eye(n), np.zeros((n, 0)), np.zeros(n)
    for start, end in pairwise(instants):
        one = expm((end - start) * whole)
        moved, pushed = one[:n, :n] @ moved, one[:n, :n] @ pushed + one[:n, n + 1]
        driven = np.column_stack([one[:n, :n] @ driven, one[:n, n]])
    return moved, np.column_stack([driven, pushed])


def close_loop(system: System) -> System:
    """The loop closed: what the law asks for is added to what is given to the machine."""
    given, asked, direct = system.b[:, [COMMAND]], system.c[[ASKED]], system.d[[ASKED]]
    out = system.d[:, [COMMAND]]
    return System(
        system.a + given @ asked,
        system.b + given @ direct,
        system.c + out @ asked,
        system.d + out @ direct,
        system.period,
    )


def reduced_system(system: System) -> tuple[System, NDArray[np.bool_]]:
    """Without the states that no input reaches, or of which no output hears; and which those left are."""
    links = system.a != 0.0
    driven, heard = (system.b != 0.0).any(axis=1), (system.c != 0.0).any(axis=0)
    kept = reachable_states(links, driven) & reachable_states(links.T, heard)
    return system.kept(kept), kept


class OpenedLoop(NamedTuple):
    """x_(k+1) = A x_k + B v_k, u_k = C x_k: v is given to the machine, u is what the law asks for."""

    a: Matrix  # A, shape (n, n)
    b: Vector  # B, shape (n,)
    c: Vector  # C, shape (n,)
    period: float  # of the samples [s]

    def transfer(self, frequencies: Vector) -> NDArray[np.complex128]:
        """L = -C (z 1 - A)^-1 B, so that the closed loop has 1 + L, at some frequencies [rad/s].

        Infinite where z is a pole.
        """
        z = np.exp(1j * np.asarray(frequencies) * self.period)
        left = z[:, np.newaxis, np.newaxis] * np.eye(len(self.a)) - self.a
        right = np.broadcast_to(self.b.astype(complex)[:, np.newaxis], (len(z), len(self.b), 1))
        regular = np.linalg.slogdet(left).sign != 0.0
        found = np.full(len(z), complex(math.inf))
        found[regular] = -(np.linalg.solve(left[regular], right[regular])[..., 0] @ self.c)
        return found

    def closed(self) -> Matrix:
        """A + B C, of the closed loop."""
        return self.a + np.outer(self.b, self.c)


class LoopVariants(NamedTuple):
    """An open loop, and the same from other differences; see :class:`~hydroservo.linear.slopes.Slopes`."""

    loop: OpenedLoop  # from exact slopes, and central differences where there are none
    of_machine: list[OpenedLoop]  # from other ones of the machine
    of_digital: list[OpenedLoop]  # from other ones of sensors and law


def opened_variants(point: OperatingPoint) -> LoopVariants:
    """A loop about where it stays, opened behind what the law is told of its own command."""
    parts, machine, digital = part_slopes(point)
    loop = assemble_loop(point, parts)
    with np.errstate(over="ignore", invalid="ignore"):
        bounded = np.isfinite(loop.closed()).all()
    if not bounded:
        problem = f"answers too strongly within {loop.period:g} s, a sample, for a linear model of its loop"
        raise ParameterError("plant", type(point.loop.plant).__name__, problem)
    return LoopVariants(
        loop,
        [assemble_loop(point, parts._replace(machine=one)) for one in machine.others],
        [assemble_loop(point, parts._replace(digital=one)) for one in digital.others],
    )


def assemble_loop(point: OperatingPoint, parts: PartSlopes) -> OpenedLoop:
    """The loop of its parts, its states by their sizes, and without those in which it is not closed."""
    whole = opened_system(point, parts).part([COMMAND], [ASKED])
    order = np.concatenate(
        [size_vector(one) for one in (point.machine, point.digital, point.digital.hold)] + [[1.0]]
    )
    a, b, c = whole.a * order / order[:, np.newaxis], whole.b / order[:, np.newaxis], whole.c * order
    system, _ = reduced_system(whole._replace(a=a, b=b, c=c))
    return OpenedLoop(system.a, system.b[:, 0], system.c[0], system.period)
