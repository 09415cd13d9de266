"""The text of blocks with CasADi's operations in place of numbers': a machine as an expression.

How the same text computes with them is in :mod:`hydroservo.core.twins`.
"""

import math
from types import SimpleNamespace
from typing import Any

from hydroservo.core.block import Block
from hydroservo.core.twins import Twins

LEAST_ROOT = 1e-30  # below it a root is 0, and its slope too, which is infinite there


def symbolic(block: Block) -> Any:
    """A block equal to another one, whose methods take CasADi's symbols.

    Where the block's text chooses, both sides are computed and one is taken; at a corner the slope is that of
    one side, and that of a root at 0 is 0.

    Fails where a method asks of a number what is asked of no symbol, as ``if`` does: with CasADi's or
    Python's own error.
    """
    return Twins(symbolic_ops(), as_number).of(block)


def symbolic_ops() -> SimpleNamespace:
    """The functions of :mod:`hydroservo.core.ops` by name, for symbols; none that draws numbers."""
    import casadi as ca

    def where(condition: Any, a: Any, b: Any) -> Any:
        return ca.if_else(condition, a, b) if is_symbol(condition) else (a if condition else b)

    def sqrt(x: Any) -> Any:
        there = x > LEAST_ROOT
        return where(there, ca.sqrt(where(there, x, 1.0)), 0.0)

    def sign(x: Any) -> Any:
        return where(x > 0.0, 1.0, where(x < 0.0, -1.0, 0.0))

    def power(x: Any, y: Any) -> Any:
        if not is_symbol(x) and x == math.e:
            return ca.exp(y)
        there = x > LEAST_ROOT
        return where(there, where(there, x, 1.0) ** y, 0.0)

    def clip(x: Any, low: Any, high: Any) -> Any:
        return where(x < low, low, where(x > high, high, x))

    def copysign(magnitude: Any, x: Any) -> Any:
        return where(x < 0.0, -1.0, 1.0) * ca.fabs(magnitude)

    def smooth_root(x: Any, transition: Any) -> Any:
        return x / ca.sqrt(ca.sqrt(x * x + transition * transition))

    return SimpleNamespace(
        where=where,
        sqrt=sqrt,
        sign=sign,
        power=power,
        clip=clip,
        copysign=copysign,
        smooth_root=smooth_root,
        signed_power=lambda x, y: copysign(power(ca.fabs(x), y), x),
        absolute=ca.fabs,
        minimum=lambda a, b: where(a < b, a, b),
        maximum=lambda a, b: where(a > b, a, b),
        sin=ca.sin,
        cos=ca.cos,
        tanh=ca.tanh,
        floor=ca.floor,
    )


def as_number(value: Any) -> Any:
    """What ``float`` gives, and a symbol as it is."""
    return value if is_symbol(value) else float(value)


def is_symbol(value: Any) -> bool:
    """Whether a value is an expression of CasADi's."""
    import casadi as ca

    return isinstance(value, ca.SX)
