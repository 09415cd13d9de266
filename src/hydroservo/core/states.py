"""Arithmetic on whole states, number by number, for interpreted and compiled code alike.

Compiled code cannot loop over the fields of a NamedTuple; the engine gives it these functions written out
for each type of state.
"""

from collections.abc import Iterator
from typing import Any

from hydroservo.core import ops
from hydroservo.core.block import Block, is_block, values

NEGLIGIBLE = 1e-150  # added to every scale, so that a state that is 0 and stays 0 misses by 0
RELATIVE_NUDGE = 2.0**-26  # root of the unit roundoff: what a difference quotient loses least with
LEAST_NUDGE = 1e-12  # of a state at rest at 0

Matrix = tuple[float, ...]  # row by row


def axpy(x: Block, h: float, k: Block) -> Block:
    """x + h k, over two states of one type."""
    if isinstance(x, tuple):
        return type(x)(*[axpy(a, h, b) for a, b in zip(x, k, strict=True)])
    return x + h * k


def scaled(h: float, k: Block) -> Block:
    """h k."""
    if isinstance(k, tuple):
        return type(k)(*[scaled(h, a) for a in k])
    return h * k


def misses(error: Block, x: Block, y: Block, rate: Block, dt: float) -> float:
    """The sum of the squares of a step's relative errors.

    Each number's error is taken relative to the largest of what it is before the step, what it is after, and
    how far its rate would carry it in dt; so numbers of any unit and size can stand side by side, and one
    that passes through zero is not asked for the impossible.

    Args:
        error: the step's error.
        x: the state before the step.
        y: the state after it.
        rate: the rates at x.
        dt: the time that a rate is weighed with [s].
    """
    if isinstance(x, tuple):
        total = 0.0
        for parts in zip(error, x, y, rate, strict=True):
            total = total + misses(*parts, dt)
        return total
    return miss(error, x, y, rate, dt)


def miss(error: float, x: float, y: float, rate: float, dt: float) -> float:
    """The square of the relative error of one number."""
    size = ops.maximum(ops.maximum(ops.absolute(x), ops.absolute(y)), dt * ops.absolute(rate))
    relative = error / (size + NEGLIGIBLE)
    return relative * relative


def filled(like: Block, numbers: Iterator[float]) -> Block:
    """A state of the same type with other numbers."""
    return type(like)(*[filled(part, numbers) if is_block(part) else next(numbers) for part in like])


def overlaid(x: Block, given: Block) -> Block:
    """A state with those numbers exchanged that a group in the same shape has."""
    parts = given._asdict().items()
    inner = {name: overlaid(getattr(x, name), part) if is_block(part) else part for name, part in parts}
    return x._replace(**inner)


def factored(system: Block, t: float, x: Block, u: Any, f: Block, h: float) -> Matrix:
    """The matrix 1/h - J, ready for :func:`solved`.

    J are the derivatives of the rates of a system by each number of its state, from forward differences. The
    matrix is split into triangles without pivoting; its diagonal holds reciprocals.
    """
    numbers, rates = values(x), values(f)
    n = len(numbers)
    rows = [[0.0] * n for _ in range(n)]
    for j in range(n):
        change = nudge(numbers[j], rates[j], h)
        nudged = (number + change if i == j else number for i, number in enumerate(numbers))
        moved = values(system.deriv(t, filled(x, nudged), u))
        for i in range(n):
            rows[i][j] = (1.0 / h if i == j else 0.0) - (moved[i] - rates[i]) / change
    for k in range(n):
        rows[k][k] = 1.0 / rows[k][k]
        for i in range(k + 1, n):
            rows[i][k] = rows[i][k] * rows[k][k]
            for j in range(k + 1, n):
                rows[i][j] = rows[i][j] - rows[i][k] * rows[k][j]
    return tuple(number for row in rows for number in row)


def nudge(number: float, rate: float, h: float) -> float:
    """By how much a number of a state is changed to see what depends on it."""
    return RELATIVE_NUDGE * (ops.absolute(number) + h * ops.absolute(rate)) + LEAST_NUDGE


def solved(matrix: Matrix, k: Block) -> Block:
    """The solution z of (1/h - J) z = k for a state ``k``."""
    z = values(k)
    n = len(z)
    for i in range(n):
        for j in range(i):
            z[i] = z[i] - matrix[n * i + j] * z[j]
    for i in reversed(range(n)):
        for j in range(i + 1, n):
            z[i] = z[i] - matrix[n * i + j] * z[j]
        z[i] = z[i] * matrix[n * i + i]
    return filled(k, iter(z))
