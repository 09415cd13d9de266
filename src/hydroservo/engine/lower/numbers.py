"""Arithmetic on numbers, known or not: what is known is computed now.

Types are promoted as in Python, whole numbers wrap at 64 bits, and a division by zero gives inf or nan, or 0
of whole numbers.
"""

import ast
import operator
from collections.abc import Callable
from typing import Any

from hydroservo.engine.lower.values import (
    BOOL,
    DOUBLE,
    INTEGER,
    LoweringError,
    Scalar,
    is_number,
    kind_of,
    operand,
    wrapped,
)
from hydroservo.engine.lower.writer import Writer, said

PYTHON: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
FLOATS: dict[type, str] = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
WHOLES: dict[type, str] = {
    ast.Add: "add",
    ast.Sub: "sub",
    ast.Mult: "mul",
    ast.LShift: "shl",
    ast.RShift: "ashr",
}
BITS: dict[type, str] = {ast.BitAnd: "and", ast.BitOr: "or", ast.BitXor: "xor"}
COMPARED: dict[type, str] = {
    ast.Eq: "eq",
    ast.NotEq: "ne",
    ast.Lt: "lt",
    ast.LtE: "le",
    ast.Gt: "gt",
    ast.GtE: "ge",
}
LONGEST_POWER = 0x10000  # beyond it a whole exponent is left to the C library


def binary(w: Writer, op: type, a: Any, b: Any) -> Any:
    """The result of an operator on two numbers."""
    if not (is_number(a) and is_number(b)):
        raise LoweringError(f"compiled code cannot compute with {said(b) if is_number(a) else said(a)}")
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        known = computed(op, a, b)
        if known is not None:
            return known
    if op is ast.Pow:
        return raised(w, a, b)
    kinds = {kind_of(a), kind_of(b)}
    if op in BITS and kinds == {BOOL}:
        return w.emit(BOOL, f"{BITS[op]} i1 {operand(a)}, {operand(b)}")
    if op is ast.Div or (DOUBLE in kinds and op not in BITS):
        return float_result(w, op, w.converted(a, DOUBLE), w.converted(b, DOUBLE))
    if DOUBLE in kinds:
        raise LoweringError("compiled code cannot take the bits of a float")
    return whole_result(w, op, w.converted(a, INTEGER), w.converted(b, INTEGER))


def computed(op: type, a: Any, b: Any) -> Any:
    """The result on numbers that are known; None where Python has none."""
    try:
        found = PYTHON[op](a, b)
    except (ArithmeticError, ValueError, TypeError):
        return None
    if isinstance(found, complex):
        return None
    return wrapped(found) if type(found) is int else found


def float_result(w: Writer, op: type, a: Any, b: Any) -> Any:
    if op in FLOATS:
        return w.emit(DOUBLE, f"{FLOATS[op]} double {operand(a)}, {operand(b)}")
    if op is ast.Mod:
        return remainder(w, a, b)
    if op is ast.FloorDiv:
        return quotient(w, a, b)
    raise LoweringError("compiled code cannot shift a float")


def whole_result(w: Writer, op: type, a: Any, b: Any) -> Any:
    x, y = operand(a), operand(b)
    if op in WHOLES or op in BITS:
        return w.emit(INTEGER, f"{WHOLES.get(op) or BITS[op]} i64 {x}, {y}")
    if op not in (ast.FloorDiv, ast.Mod):
        raise LoweringError(f"compiled code does not support the operator {op.__name__}")
    zero = w.emit(BOOL, f"icmp eq i64 {y}, 0")
    divisor = w.emit(INTEGER, f"select i1 {zero.text}, i64 1, i64 {y}").text if isinstance(b, Scalar) else y
    ratio = w.emit(INTEGER, f"sdiv i64 {x}, {divisor}")
    left = w.emit(INTEGER, f"srem i64 {x}, {divisor}")
    uneven = w.emit(BOOL, f"icmp ne i64 {left.text}, 0")
    signs = w.emit(INTEGER, f"xor i64 {left.text}, {divisor}")
    apart = w.emit(BOOL, f"icmp slt i64 {signs.text}, 0")
    below = w.emit(BOOL, f"and i1 {uneven.text}, {apart.text}")
    if op is ast.FloorDiv:
        less = w.emit(INTEGER, f"sext i1 {below.text} to i64")
        found = w.emit(INTEGER, f"add i64 {ratio.text}, {less.text}")
    else:
        more = w.emit(INTEGER, f"select i1 {below.text}, i64 {divisor}, i64 0")
        found = w.emit(INTEGER, f"add i64 {left.text}, {more.text}")
    return w.emit(INTEGER, f"select i1 {zero.text}, i64 0, i64 {found.text}")


def remainder(w: Writer, a: Any, b: Any) -> Any:
    """a - b floor(a/b), as Python rounds it."""
    rest = w.emit(DOUBLE, f"frem double {operand(a)}, {operand(b)}")
    signed = w.call("llvm.copysign.f64", DOUBLE, [0.0, b])
    below = truth(w, binary(w, ast.BitAnd, compared(w, ast.NotEq, rest, 0.0), differ(w, rest, b)))
    turned = w.selected(below, binary(w, ast.Add, rest, b), rest)
    return w.selected(truth(w, compared(w, ast.Eq, rest, 0.0)), signed, turned)


def quotient(w: Writer, a: Any, b: Any) -> Any:
    """floor(a/b), as Python rounds it."""
    rest = w.emit(DOUBLE, f"frem double {operand(a)}, {operand(b)}")
    ratio = binary(w, ast.Div, binary(w, ast.Sub, a, rest), b)
    below = truth(w, binary(w, ast.BitAnd, compared(w, ast.NotEq, rest, 0.0), differ(w, rest, b)))
    ratio = w.selected(below, binary(w, ast.Sub, ratio, 1.0), ratio)
    low = w.call("llvm.floor.f64", DOUBLE, [ratio])
    off = truth(w, compared(w, ast.Gt, binary(w, ast.Sub, ratio, low), 0.5))
    nearest = w.selected(off, binary(w, ast.Add, low, 1.0), low)
    exact = binary(w, ast.Div, a, b)
    zero = w.call("llvm.copysign.f64", DOUBLE, [0.0, exact])
    found = w.selected(truth(w, compared(w, ast.NotEq, ratio, 0.0)), nearest, zero)
    return w.selected(truth(w, compared(w, ast.Eq, b, 0.0)), exact, found)


def differ(w: Writer, a: Any, b: Any) -> Any:
    """Whether exactly one of two is below 0."""
    return binary(w, ast.BitXor, compared(w, ast.Lt, a, 0.0), compared(w, ast.Lt, b, 0.0))


def raised(w: Writer, a: Any, b: Any) -> Any:
    """a^b; a whole number that is known as exponent makes products."""
    if (
        isinstance(b, Scalar)
        or not isinstance(b, int)
        or abs(b) > LONGEST_POWER
        or (b < 0 and kind_of(a) != DOUBLE)
    ):
        return w.call("llvm.pow.f64", DOUBLE, [w.converted(a, DOUBLE), w.converted(b, DOUBLE)])
    left, found = abs(b), None
    while left:
        if left & 1:
            found = a if found is None else binary(w, ast.Mult, found, a)
        left >>= 1
        a = binary(w, ast.Mult, a, a) if left else a
    if found is None:
        return 1.0 if kind_of(a) == DOUBLE else 1
    return binary(w, ast.Div, 1.0, found) if b < 0 else found


def compared(w: Writer, op: type, a: Any, b: Any) -> Any:
    """Whether two numbers compare so."""
    if not (is_number(a) and is_number(b)):
        raise LoweringError(f"compiled code cannot compare {said(a)} with {said(b)}")
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return PYTHON[op](a, b)
    kinds, name = {kind_of(a), kind_of(b)}, COMPARED[op]
    if DOUBLE in kinds:
        x, y = (operand(w.converted(value, DOUBLE)) for value in (a, b))
        return w.emit(BOOL, f"fcmp {'u' if name == 'ne' else 'o'}{name} double {x}, {y}")
    x, y = (operand(w.converted(value, INTEGER)) for value in (a, b))
    return w.emit(BOOL, f"icmp {name if op in (ast.Eq, ast.NotEq) else f's{name}'} i64 {x}, {y}")


def truth(w: Writer, value: Any) -> Any:
    """Whether a value counts as true: a Python bool where that is known."""
    if isinstance(value, Scalar):
        return value if value.kind == BOOL else compared(w, ast.NotEq, value, 0)
    if is_number(value) or isinstance(value, str | None):
        return bool(value)
    raise LoweringError(f"compiled code cannot take {said(value)} as true or false")


def inverted(w: Writer, value: Any) -> Any:
    """Whether a value counts as false."""
    found = truth(w, value)
    return w.emit(BOOL, f"xor i1 {found.text}, true") if isinstance(found, Scalar) else not found


def negated(w: Writer, value: Any) -> Any:
    """Minus a number."""
    if not isinstance(value, Scalar):
        return binary(w, ast.Mult, -1, value) if not isinstance(value, float) else -value
    if value.kind == DOUBLE:
        return w.emit(DOUBLE, f"fneg double {value.text}")
    return binary(w, ast.Sub, 0, value)


def absolute(w: Writer, value: Any) -> Any:
    """The size of a number."""
    if not isinstance(value, Scalar):
        return abs(value)
    if value.kind == DOUBLE:
        return w.call("llvm.fabs.f64", DOUBLE, [value])
    return w.selected(compared(w, ast.Lt, value, 0), negated(w, value), w.converted(value, INTEGER))


def floating(w: Writer, value: Any) -> Any:
    """A number as a float."""
    return w.converted(value, DOUBLE)


def whole(w: Writer, value: Any) -> Any:
    """A number as an int, without what stands behind its point."""
    if isinstance(value, Scalar) and value.kind == DOUBLE:
        return w.emit(INTEGER, f"fptosi double {value.text} to i64")
    if isinstance(value, float):
        return (
            wrapped(int(value))
            if value - value == 0.0
            else w.emit(INTEGER, f"fptosi double {operand(value)} to i64")
        )
    return w.converted(value, INTEGER)
