"""Functions that are an instruction or two, and those of the C library."""

import ast
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from hydroservo.engine import flat
from hydroservo.engine.lower import numbers
from hydroservo.engine.lower.values import (
    ADDRESS,
    BOOL,
    DOUBLE,
    INTEGER,
    Array,
    Record,
    Scalar,
    kind_of,
    operand,
)
from hydroservo.engine.lower.writer import Writer
from hydroservo.ops import basic, binary

ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
BIASED_ROUNDER = basic.ROUNDER + 2046.0  # leaves a whole number plus twice the bias in the lowest bits
LIBRARY = (  # of C, by the names that Python's math has too
    *(
        "acos",
        "acosh",
        "asin",
        "asinh",
        "atan",
        "atan2",
        "atanh",
        "cbrt",
        "cos",
        "cosh",
        "erf",
        "erfc",
        "exp",
    ),
    *("expm1", "fmod", "hypot", "log10", "log1p", "log2", "pow", "sin", "sinh", "tan", "tanh"),
)

Instruction = Callable[..., Any]


def llvm(name: str) -> Instruction:
    """A function of LLVM on floats, which is one instruction of most processors."""
    return lambda w, *given: w.call(f"llvm.{name}.f64", DOUBLE, [numbers.floating(w, one) for one in given])


def library(name: str) -> Instruction:
    """A function of the C library on floats."""
    return lambda w, *given: w.call(name, DOUBLE, [numbers.floating(w, one) for one in given])


def rounded(name: str) -> Instruction:
    """A rounding that Python makes a whole number."""
    return lambda w, x: numbers.whole(w, llvm(name)(w, x))


def bits(w: Writer, x: Any) -> Scalar:
    """The bits of a float as an integer."""
    return w.emit(INTEGER, f"bitcast double {operand(numbers.floating(w, x))} to i64")


def from_bits(w: Writer, n: Any) -> Scalar:
    """The float that has these bits."""
    return w.emit(DOUBLE, f"bitcast i64 {operand(n)} to double")


def above_root_half(w: Writer, x: Scalar) -> Any:
    """The whole number e for which x = 2^e m with m in [sqrt(1/2), sqrt(2))."""
    return numbers.binary(w, ast.RShift, numbers.binary(w, ast.Sub, x, ROOT_HALF_BITS), 52)


def exponent(w: Writer, x: Any) -> Any:
    return numbers.floating(w, above_root_half(w, bits(w, x)))


def mantissa(w: Writer, x: Any) -> Any:
    found = bits(w, x)
    shifted = numbers.binary(w, ast.LShift, above_root_half(w, found), 52)
    return from_bits(w, numbers.binary(w, ast.Sub, found, shifted))


def scaled(w: Writer, x: Any, n: Any) -> Any:
    """In two steps of half the exponent each, of which the last alone can round."""
    biased = bits(w, numbers.binary(w, ast.Add, n, BIASED_ROUNDER))
    half = numbers.binary(w, ast.RShift, biased, 1)
    for part in (half, numbers.binary(w, ast.Sub, biased, half)):
        x = numbers.binary(w, ast.Mult, x, from_bits(w, numbers.binary(w, ast.LShift, part, 52)))
    return x


def array_at(w: Writer, address: Any, lengths: Record) -> Array:
    """An array that owns nothing: kernels allocate and free no memory."""
    return Array([w.emit(ADDRESS, f"inttoptr i64 {operand(address)} to ptr"), *lengths.parts])


def is_nan(w: Writer, x: Any) -> Any:
    return numbers.compared(w, ast.NotEq, x, x)


def is_infinite(w: Writer, x: Any) -> Any:
    return numbers.compared(w, ast.Eq, numbers.absolute(w, numbers.floating(w, x)), math.inf)


def is_finite(w: Writer, x: Any) -> Any:
    rest = numbers.binary(w, ast.Sub, numbers.floating(w, x), numbers.floating(w, x))
    return numbers.compared(w, ast.Eq, rest, 0.0)


def logarithm(w: Writer, x: Any, *base: Any) -> Any:
    found = library("log")(w, x)
    return numbers.binary(w, ast.Div, found, library("log")(w, base[0])) if base else found


def least(w: Writer, first: Any, *others: Any) -> Any:
    return extreme(w, ast.Lt, first, *others)


def largest(w: Writer, first: Any, *others: Any) -> Any:
    return extreme(w, ast.Gt, first, *others)


def extreme(w: Writer, op: type, *given: Any) -> Any:
    """The first of some numbers than which none is smaller, or larger."""
    found, *others = given[0].parts if len(given) == 1 and isinstance(given[0], Record) else given
    for other in others:
        better = numbers.truth(w, numbers.compared(w, op, other, found))
        found = w.selected(better, other, found) if isinstance(better, Scalar) else other if better else found
    return found


def flag(w: Writer, x: Any = False) -> Any:
    return numbers.truth(w, x)


def nearest(w: Writer, x: Any) -> Any:
    """The nearest whole number, the even one of two."""
    return x if kind_of(x) in (INTEGER, BOOL) else numbers.whole(w, llvm("rint")(w, x))


INSTRUCTIONS: dict[Any, Instruction] = {
    basic.absolute: llvm("fabs"),
    basic.copysign: llvm("copysign"),
    basic.sqrt: llvm("sqrt"),
    basic.floor: llvm("floor"),
    binary.exponent: exponent,
    binary.mantissa: mantissa,
    binary.scaled: scaled,
    flat.array_at: array_at,
    abs: numbers.absolute,
    bool: flag,
    float: numbers.floating,
    int: numbers.whole,
    max: largest,
    min: least,
    round: nearest,
    math.ceil: rounded("ceil"),
    math.copysign: llvm("copysign"),
    math.fabs: llvm("fabs"),
    math.floor: rounded("floor"),
    math.isfinite: is_finite,
    math.isinf: is_infinite,
    math.isnan: is_nan,
    math.log: logarithm,
    math.sqrt: llvm("sqrt"),
    math.trunc: numbers.whole,
    np.abs: numbers.absolute,
    np.ceil: llvm("ceil"),
    np.copysign: llvm("copysign"),
    np.fabs: llvm("fabs"),
    np.floor: llvm("floor"),
    np.isfinite: is_finite,
    np.isinf: is_infinite,
    np.isnan: is_nan,
    np.log: library("log"),
    np.sqrt: llvm("sqrt"),
}
INSTRUCTIONS |= {getattr(math, name): library(name) for name in LIBRARY}
INSTRUCTIONS |= {getattr(np, name): library(name) for name in LIBRARY if name != "pow" and name in vars(np)}
