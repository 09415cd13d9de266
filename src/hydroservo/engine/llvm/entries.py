"""Functions that are called from outside, as the text of a module for LLVM."""

from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.engine.llvm.instructions import WRITTEN
from hydroservo.engine.llvm.values import NUMBERS, runtime_fields
from hydroservo.engine.llvm.writer import LLVMWriter
from hydroservo.engine.native import CompileError
from hydroservo.language.names import snake
from hydroservo.language.program import Program
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import BOOL, INT, NOTHING, REAL, Array, Function, Known, Memory, Record, Type

DOUBLES, INTEGERS = Memory(REAL), Memory(INT)
TYPES: dict[type, Type] = {float: REAL, int: INT, bool: BOOL, type(None): NOTHING}
PYTHON_TYPES: dict[Type, type] = {kind: cls for cls, kind in TYPES.items()}


def kernel_text(name: str, function: Callable[..., Any], kinds: Sequence[Type]) -> str:
    """The module of a function of numbers and memory that returns a whole number, as ``Native`` calls it."""
    w, made = LLVMWriter(), translated_terms(function, lambda _: kinds)
    found = w.inlined(made, [f"%a{i}" for i in range(len(kinds))])
    whole = found if made.returns == INT else w.emit(f"zext i1 {found} to i64")
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
    numbers: list[tuple[Type, str]] = []
    shape = gather_numbers(made.returns, found, numbers)
    for i, (kind, number) in enumerate(numbers):
        value = w.emit(f"zext i1 {number} to i64") if kind == BOOL else number
        word = "double" if kind == REAL else "i64"
        w.line(f"store {word} {value}, ptr {w.emit(f'getelementptr {word}, ptr %results, i64 {i}')}, align 8")
    return w.text(name, ["ptr %doubles", "ptr %integers", "ptr %results"]), shape


def translated_terms(function: Any, kinds: Callable[[Program], Sequence[Type]]) -> Function:
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


def argument_type(program: Program, shape: Any) -> Type:
    """The type of an argument of a shape."""
    if isinstance(shape, tuple):
        cls, *parts = shape
        if cls is Array:
            return Array(*parts)
        names = getattr(cls, "_fields", [f"value_{i}" for i in range(1, len(parts) + 1)])
        kinds = {name: argument_type(program, part) for name, part in zip(names, parts, strict=True)}
        return program.record(None if cls is tuple else cls, kinds, snake(cls.__name__))
    if isinstance(shape, Known):
        return shape
    if shape not in TYPES:
        raise TranslationError(f"compiled code does not take values of the type {shape.__name__}")
    return TYPES[shape]


class Arguments:
    """Reads arguments from memory."""

    def __init__(self) -> None:
        self.writer = LLVMWriter()
        self.doubles = self.integers = 0

    def value(self, kind: Type) -> Any:
        """What stands for an argument of a type."""
        if isinstance(kind, Record):
            return [self.value(part) for part in runtime_fields(kind).values()]
        if isinstance(kind, Array):
            start = self.writer.emit(f"inttoptr i64 {self.integer()} to ptr")
            return [start, *(self.integer() for _ in kind.lengths)]
        if kind == REAL:
            self.doubles += 1
            return self.loaded("double", f"ptr %doubles, i64 {self.doubles - 1}")
        return self.integer() if kind == INT else self.writer.emit(f"icmp ne i64 {self.integer()}, 0")

    def integer(self) -> str:
        self.integers += 1
        return self.loaded("i64", f"ptr %integers, i64 {self.integers - 1}")

    def loaded(self, word: str, place: str) -> str:
        at = self.writer.emit(f"getelementptr {word}, {place}")
        return self.writer.emit(f"load {word}, ptr {at}, align 8")


def gather_numbers(kind: Type, value: Any, numbers: list[tuple[Type, str]]) -> Any:
    """The shape of a value, whose numbers go into a list."""
    if isinstance(kind, Record):
        values = dict(zip(runtime_fields(kind), value, strict=True))
        parts = [gather_numbers(part, values.get(name), numbers) for name, part in kind.fields.items()]
        return (kind.cls or tuple, *parts)
    if isinstance(kind, Known):
        return kind
    if kind not in NUMBERS:
        raise CompileError("compiled code cannot return an array")
    numbers.append((kind, value))
    return PYTHON_TYPES[kind]
