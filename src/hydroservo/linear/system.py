"""A loop opened at its command, from one sample to the next: states, inputs and outputs by number."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import values
from hydroservo.linear.operating_point import DigitalState, OperatingPoint
from hydroservo.linear.parts import Parts, jumps, sizes
from hydroservo.linear.slopes import reached

Matrix = NDArray[np.float64]
Response = NDArray[np.complex128]

COMMAND = 0  # inputs: what is given to the machine, r, F
DEMAND = slice(1, 4)
FORCE = 4
ASKED = 0  # the first output: what the law asks for; then come what is seen, and what is controlled


class System(NamedTuple):
    """x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k; of a period 0: dx/dt = A x + B u, y = C x + D u.

    Attributes:
        a: A, shape (n, n).
        b: B, shape (n, inputs).
        c: C, shape (outputs, n).
        d: D, shape (outputs, inputs).
        period: of the samples [s]; 0 in continuous time.
    """

    a: Matrix
    b: Matrix
    c: Matrix
    d: Matrix
    period: float

    def part(self, inputs: list[int], outputs: list[int]) -> "System":
        """The same with some of its inputs and outputs."""
        d = self.d[np.ix_(outputs, inputs)]
        return System(self.a, self.b[:, inputs], self.c[outputs], d, self.period)

    def kept(self, states: NDArray[np.bool_]) -> "System":
        """The same with some of its states, which the others do not move."""
        a = self.a[np.ix_(states, states)]
        return System(a, self.b[states], self.c[:, states], self.d, self.period)


@np.errstate(invalid="ignore")  # scipy reads a permutation, not asked for, from large scales
def response(system: System, frequencies: NDArray[np.float64], columns: Response | None = None) -> Response:
    """G = C (z 1 - A)^-1 B + D at some frequencies [rad/s], shape (frequencies, outputs, inputs).

    z is e^(j w h), or j w in continuous time. Rows and columns are balanced before, for SI numbers go from
    micrometres to hundreds of bar.

    Args:
        system: A, B, C, D.
        frequencies: w [rad/s].
        columns: in place of B where that depends on the frequency, shape (frequencies, n, inputs).
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


def pushed(point: OperatingPoint, parts: Parts, frequencies: NDArray[np.float64]) -> Response:
    """What a tone of the force adds to the machine's states over a sample, shape (frequencies, states).

    A load is no command: it goes on between samples. With F e^(j w t) that is, exactly,
    (j w 1 - A)^-1 (e^(j w h) 1 - e^(A h)) B_F.
    """
    from scipy.linalg import expm

    n, h = len(values(point.machine)), point.loop.simulation.period
    scale = sizes(point.machine)
    a, b = parts.machine[:n, :n] * scale / scale[:, np.newaxis], parts.machine[:n, n + 1] / scale
    s = 1j * np.asarray(frequencies, dtype=np.float64)[:, np.newaxis, np.newaxis]
    moved = (np.exp(s * h) * np.eye(n) - expm(h * a)) @ b[:, np.newaxis]
    return np.asarray(np.linalg.solve(s * np.eye(n) - a, moved)[..., 0] * scale)


@np.errstate(all="ignore")  # what is lost is not finite, and refused as that
def opened_system(point: OperatingPoint, parts: Parts) -> System:
    """A loop opened at its command, in states [x, w, those of the machine's hold, the last command].

    The machine moves between samples as its rates, linearised, say exactly, with the force held over a sample
    as the command is; sensors, law and hold step at samples. The loop is opened behind what the law is told
    of its own command.
    """
    n, m, k = (len(values(one)) for one in (point.machine, point.digital, point.digital.hold))
    x, w, h, last = slice(0, n), slice(n, n + m), slice(n + m, n + m + k), n + m + k
    a, b = np.zeros((last + 1, last + 1)), np.zeros((last + 1, 5))
    scale = sizes(point.machine, 1.0, 1.0)
    moved, driven = between(parts.machine[:n] * scale / scale[:n, np.newaxis], jumps(point))
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
    asked = n + command_place(point.digital)
    c[ASKED], d[ASKED] = a[asked], b[asked]
    c[1:, x], d[1:, COMMAND], d[1:, FORCE] = seen[:, :n], seen[:, n], seen[:, n + 1]
    return System(a, b, c, d, point.loop.simulation.period)


def between(table: Matrix, instants: list[float]) -> tuple[Matrix, Matrix]:
    """How a machine moves over a period: by its states, shape (n, n), and by what drives it.

    Args:
        table: its rates by [states, command, force].
        instants: between which the command is constant; the force always is.

    Returns:
        The second has a column for each command, and the last one for the force.
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


def command_place(digital: DigitalState) -> int:
    """Where the law's command is among the numbers of the digital states."""
    before = digital.controller._fields.index("u")
    return len(values(digital.sensors)) + len(values(digital.controller[:before]))


def closed(system: System) -> System:
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


def reduced(system: System) -> tuple[System, NDArray[np.bool_]]:
    """Without the states that no input reaches, or of which no output hears; and which those left are."""
    links = system.a != 0.0
    driven, heard = (system.b != 0.0).any(axis=1), (system.c != 0.0).any(axis=0)
    kept = reached(links, driven) & reached(links.T, heard)
    return system.kept(kept), kept
