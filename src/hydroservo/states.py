"""Arithmetic on whole states, number by number, for interpreted and compiled code alike.

Compiled code cannot loop over the fields of a NamedTuple; the engine gives it these functions written out
for each type of state.
"""

from hydroservo import ops
from hydroservo.block import Block

__all__ = ["axpy", "miss", "misses", "scaled"]

NEGLIGIBLE = 1e-150  # added to every scale, so that a state that is 0 and stays 0 misses by 0


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
