"""A loop opened at the command, for small motions: from what is given to the machine to what a law asks."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError
from hydroservo.linear.operating_point import OperatingPoint
from hydroservo.linear.parts import Parts, parts_of, sizes
from hydroservo.linear.system import ASKED, COMMAND, opened_system, reduced

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


class Variants(NamedTuple):
    """An open loop, and the same from other differences; see :class:`~hydroservo.linear.slopes.Slopes`.

    Attributes:
        loop: from exact slopes, and central differences where there are none.
        of_machine: from other ones of the machine.
        of_digital: from other ones of sensors and law.
    """

    loop: OpenLoop
    of_machine: list[OpenLoop]
    of_digital: list[OpenLoop]


def opened(point: OperatingPoint) -> Variants:
    """A loop about where it stays, opened behind what the law is told of its own command."""
    parts, machine, digital = parts_of(point)
    loop = put_together(point, parts)
    with np.errstate(over="ignore", invalid="ignore"):
        bounded = np.isfinite(loop.closed()).all()
    if not bounded:
        problem = f"answers too strongly within {loop.period:g} s, a sample, for a linear model of its loop"
        raise ParameterError("plant", type(point.loop.plant).__name__, problem)
    return Variants(
        loop,
        [put_together(point, parts._replace(machine=one)) for one in machine.others],
        [put_together(point, parts._replace(digital=one)) for one in digital.others],
    )


def put_together(point: OperatingPoint, parts: Parts) -> OpenLoop:
    """The loop of its parts, its states by their sizes, and without those in which it is not closed."""
    whole = opened_system(point, parts).part([COMMAND], [ASKED])
    order = np.concatenate(
        [sizes(one) for one in (point.machine, point.digital, point.digital.hold)] + [[1.0]]
    )
    a, b, c = whole.a * order / order[:, np.newaxis], whole.b / order[:, np.newaxis], whole.c * order
    system, _ = reduced(whole._replace(a=a, b=b, c=c))
    return OpenLoop(system.a, system.b[:, 0], system.c[0], system.period)
