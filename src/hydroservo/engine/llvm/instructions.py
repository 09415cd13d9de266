"""The functions of ops that are an instruction or some, and those on whole states."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.core.ops import basic, binary
from hydroservo.engine import state_text
from hydroservo.engine.llvm.values import FunctionValues, float_literal
from hydroservo.language import functions
from hydroservo.language.terms import INT, REAL, Function, Translator, Type

ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
BIASED_ROUNDER = float_literal(
    basic.ROUNDER + 2046.0
)  # leaves a whole number plus twice the bias in the lowest bits
Written = Callable[..., str]


def llvm(name: str) -> Written:
    """A function of LLVM on floats, which is one instruction of most processors."""

    def call(w: FunctionValues, *given: str) -> str:
        function = w.declare(f"llvm.{name}.f64", "double", *["double"] * len(given))
        return w.emit(f"call double {function}({', '.join(f'double {one}' for one in given)})")

    return call


def remainder(w: FunctionValues, a: str, b: str) -> str:
    return w.emit(f"frem double {a}, {b}")


def above_root_half(w: FunctionValues, bits: str) -> str:
    """The whole number e for which x = 2^e m with m in [sqrt(1/2), sqrt(2))."""
    return w.emit(f"ashr i64 {w.emit(f'sub i64 {bits}, {ROOT_HALF_BITS}')}, 52")


def exponent_code(w: FunctionValues, x: str) -> str:
    return w.emit(f"sitofp i64 {above_root_half(w, bits_of(w, x))} to double")


def mantissa_code(w: FunctionValues, x: str) -> str:
    bits = bits_of(w, x)
    shifted = w.emit(f"shl i64 {above_root_half(w, bits)}, 52")
    return from_bits(w, w.emit(f"sub i64 {bits}, {shifted}"))


def scaled_code(w: FunctionValues, x: str, n: str) -> str:
    """In two steps of half the exponent each, of which the last alone can round."""
    biased = bits_of(w, w.emit(f"fadd double {n}, {BIASED_ROUNDER}"))
    half = w.emit(f"ashr i64 {biased}, 1")
    for part in (half, w.emit(f"sub i64 {biased}, {half}")):
        x = w.emit(f"fmul double {x}, {from_bits(w, w.emit(f'shl i64 {part}, 52'))}")
    return x


def bits_of(w: FunctionValues, x: str) -> str:
    """The bits of a float as an integer."""
    return w.emit(f"bitcast double {x} to i64")


def from_bits(w: FunctionValues, n: str) -> str:
    """The float that has these bits."""
    return w.emit(f"bitcast i64 {n} to double")


def quotient_code(w: FunctionValues, a: str, b: str) -> str:
    """floor(a/b) of whole numbers; 0 where b is 0."""
    zero, _, ratio, _, below = division(w, a, b)
    less = w.emit(f"sext i1 {below} to i64")
    return w.emit(f"select i1 {zero}, i64 0, i64 {w.emit(f'add i64 {ratio}, {less}')}")


def modulo_code(w: FunctionValues, a: str, b: str) -> str:
    """a - b floor(a/b) of whole numbers; 0 where b is 0."""
    zero, divisor, _, rest, below = division(w, a, b)
    more = w.emit(f"select i1 {below}, i64 {divisor}, i64 0")
    return w.emit(f"select i1 {zero}, i64 0, i64 {w.emit(f'add i64 {rest}, {more}')}")


def division(w: FunctionValues, a: str, b: str) -> tuple[str, str, str, str, str]:
    """Whether b is 0, b or 1 then, quotient and rest towards 0, and whether the floor is below."""
    zero = w.emit(f"icmp eq i64 {b}, 0")
    divisor = w.emit(f"select i1 {zero}, i64 1, i64 {b}")
    ratio, rest = w.emit(f"sdiv i64 {a}, {divisor}"), w.emit(f"srem i64 {a}, {divisor}")
    uneven = w.emit(f"icmp ne i64 {rest}, 0")
    apart = w.emit(f"icmp slt i64 {w.emit(f'xor i64 {rest}, {divisor}')}, 0")
    return zero, divisor, ratio, rest, w.emit(f"and i1 {uneven}, {apart}")


INSTRUCTIONS: dict[Any, tuple[Any, ...]] = {  # and of how many numbers, floats where it is not said
    basic.absolute: (llvm("fabs"), 1),
    basic.copysign: (llvm("copysign"), 2),
    basic.sqrt: (llvm("sqrt"), 1),
    basic.floor: (llvm("floor"), 1),
    binary.exponent: (exponent_code, 1),
    binary.mantissa: (mantissa_code, 1),
    binary.scaled: (scaled_code, 2),
    math.fmod: (remainder, 2),
    functions.whole_modulo: (modulo_code, 2, INT),
    functions.whole_quotient: (quotient_code, 2, INT),
}


def instruction(
    name: str, written: Written, numbers: int, kind: Type = REAL
) -> Callable[[Translator, Sequence[Type]], Function]:
    taken = [(f"x{i}", kind) for i in range(numbers)]
    function = Function(name, taken, returns=kind, written=written)
    return lambda _, __: function


WRITTEN: dict[Any, Callable[[Translator, Sequence[Type]], Function]] = {
    **{origin: instruction(origin.__name__, *how) for origin, how in INSTRUCTIONS.items()},
    **state_text.TRANSLATED,
}
