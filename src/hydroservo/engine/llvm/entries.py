"""Functions that are called from outside, as the text of a module for LLVM."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.core.ops import basic, binary
from hydroservo.engine import state_text
from hydroservo.engine.llvm.values import NUMBERS, FunctionValues, float_literal, runtime_fields
from hydroservo.engine.llvm.writer import LLVMWriter
from hydroservo.engine.native import CompileError
from hydroservo.language import functions, terms
from hydroservo.language.names import snake
from hydroservo.language.program import Program
from hydroservo.language.scope import TranslationError

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
    functions.whole_modulo: (modulo_code, 2, terms.INT),
    functions.whole_quotient: (quotient_code, 2, terms.INT),
}


def instruction(
    name: str, written: Written, numbers: int, kind: terms.Type = terms.REAL
) -> Callable[[terms.Translator, Sequence[terms.Type]], terms.Function]:
    taken = [(f"x{i}", kind) for i in range(numbers)]
    function = terms.Function(name, taken, returns=kind, written=written)
    return lambda _, __: function


WRITTEN: dict[Any, Callable[[terms.Translator, Sequence[terms.Type]], terms.Function]] = {
    **{origin: instruction(origin.__name__, *how) for origin, how in INSTRUCTIONS.items()},
    **state_text.TRANSLATED,
}

DOUBLES, INTEGERS = terms.Memory(terms.REAL), terms.Memory(terms.INT)
TYPES: dict[type, terms.Type] = {
    float: terms.REAL,
    int: terms.INT,
    bool: terms.BOOL,
    type(None): terms.NOTHING,
}
PYTHON_TYPES: dict[terms.Type, type] = {kind: cls for cls, kind in TYPES.items()}


def kernel_text(name: str, function: Callable[..., Any], kinds: Sequence[terms.Type]) -> str:
    """The module of a function of numbers and memory that returns a whole number, as ``Native`` calls it."""
    w, made = LLVMWriter(), translated_terms(function, lambda _: kinds)
    found = w.inlined(made, [f"%a{i}" for i in range(len(kinds))])
    whole = found if made.returns == terms.INT else w.emit(f"zext i1 {found} to i64")
    w.line(f"store i64 {whole}, ptr %result, align 8")
    return w.text(
        name, ["ptr %result", *(f"{NUMBERS.get(kind, 'ptr')} %a{i}" for i, kind in enumerate(kinds))]
    )


def method_text(name: str, function: Callable[..., Any], shapes: Sequence[Any]) -> tuple[str, Any]:
    """The module of a function of blocks and numbers, and the shape of what it returns.

    Its arguments are in memory: floats in a row of doubles, all else in one of integers.
    """
    made = translated_terms(function, lambda program: [argument_type(program, shape) for shape in shapes])
    arguments = Arguments()
    w = arguments.writer
    found = w.inlined(made, [arguments.value(kind) for _, kind in made.parameters])
    numbers: list[tuple[terms.Type, str]] = []
    shape = gather_numbers(made.returns, found, numbers)
    for i, (kind, number) in enumerate(numbers):
        value = w.emit(f"zext i1 {number} to i64") if kind == terms.BOOL else number
        word = "double" if kind == terms.REAL else "i64"
        w.line(f"store {word} {value}, ptr {w.emit(f'getelementptr {word}, ptr %results, i64 {i}')}, align 8")
    return w.text(name, ["ptr %doubles", "ptr %integers", "ptr %results"]), shape


def translated_terms(function: Any, kinds: Callable[[Program], Sequence[terms.Type]]) -> terms.Function:
    """The terms of a function for arguments of some types.

    Raises:
        CompileError: its text is not in the language.
    """
    program = Program(WRITTEN, "")
    try:
        return program.function(function, kinds(program))
    except TranslationError as error:
        raise CompileError(error.problem, error.places) from None
    except RecursionError:
        problem = "its expressions or calls nest too deeply; give parts of them names"
        raise CompileError(
            problem, [(function.__code__.co_filename, function.__code__.co_firstlineno)]
        ) from None


def argument_type(program: Program, shape: Any) -> terms.Type:
    if isinstance(shape, tuple):
        cls, *parts = shape
        if cls is terms.Array:
            return terms.Array(*parts)
        names = getattr(cls, "_fields", [f"value_{i}" for i in range(1, len(parts) + 1)])
        kinds = {name: argument_type(program, part) for name, part in zip(names, parts, strict=True)}
        return program.record(None if cls is tuple else cls, kinds, snake(cls.__name__))
    if isinstance(shape, terms.Known):
        return shape
    if shape not in TYPES:
        raise TranslationError(f"compiled code does not take values of the type {shape.__name__}")
    return TYPES[shape]


class Arguments:
    """Reads arguments from memory."""

    def __init__(self) -> None:
        self.writer = LLVMWriter()
        self.doubles = self.integers = 0

    def value(self, kind: terms.Type) -> Any:
        """What stands for an argument of a type."""
        if isinstance(kind, terms.Record):
            return [self.value(part) for part in runtime_fields(kind).values()]
        if isinstance(kind, terms.Array):
            start = self.writer.emit(f"inttoptr i64 {self.integer()} to ptr")
            return [start, *(self.integer() for _ in kind.lengths)]
        if kind == terms.REAL:
            self.doubles += 1
            return self.loaded("double", f"ptr %doubles, i64 {self.doubles - 1}")
        return self.integer() if kind == terms.INT else self.writer.emit(f"icmp ne i64 {self.integer()}, 0")

    def integer(self) -> str:
        self.integers += 1
        return self.loaded("i64", f"ptr %integers, i64 {self.integers - 1}")

    def loaded(self, word: str, place: str) -> str:
        at = self.writer.emit(f"getelementptr {word}, {place}")
        return self.writer.emit(f"load {word}, ptr {at}, align 8")


def gather_numbers(kind: terms.Type, value: Any, numbers: list[tuple[terms.Type, str]]) -> Any:
    """The shape of a value, whose numbers go into a list."""
    if isinstance(kind, terms.Record):
        values = dict(zip(runtime_fields(kind), value, strict=True))
        parts = [gather_numbers(part, values.get(name), numbers) for name, part in kind.fields.items()]
        return (kind.cls or tuple, *parts)
    if isinstance(kind, terms.Known):
        return kind
    if kind not in NUMBERS:
        raise CompileError("compiled code cannot return an array")
    numbers.append((kind, value))
    return PYTHON_TYPES[kind]
