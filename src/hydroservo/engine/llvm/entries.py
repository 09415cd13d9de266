"""Functions that are called from outside, as the text of a module for LLVM."""

from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.engine.llvm.body import function_text
from hydroservo.engine.llvm.instructions import WRITTEN
from hydroservo.engine.llvm.module import NUMBERS, Module, fields_of
from hydroservo.engine.llvm.values import Values
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
    made = translated(function, lambda _: kinds)
    module = Module(function_text)
    w = Values(module)
    given = [f"{module.type(kind)} %a{i}" for i, kind in enumerate(kinds)]
    found = called(w, made, given)
    whole = found if made.returns == INT else w.emit(f"zext i1 {found} to i64")
    w.line(f"store i64 {whole}, ptr %result, align 8")
    return entry(w, name, ["ptr %result", *given])


def method_text(name: str, function: Callable[..., Any], shapes: Sequence[Any]) -> tuple[str, Any]:
    """The module of a function of blocks and numbers, and the shape of what it returns.

    Its arguments are in memory: floats in a row of doubles, all else in one of integers.
    """
    made = translated(function, lambda program: [kind_of(program, shape) for shape in shapes])
    module = Module(function_text)
    arguments = Arguments(Values(module))
    w = arguments.body
    given = [f"{module.type(kind)} {arguments.value(kind)}" for _, kind in made.parameters]
    found = called(w, made, given)
    numbers: list[tuple[Type, str]] = []
    shape = gathered(w, made.returns, found, numbers)
    for i, (kind, number) in enumerate(numbers):
        value = w.emit(f"zext i1 {number} to i64") if kind == BOOL else number
        word = "double" if kind == REAL else "i64"
        w.line(f"store {word} {value}, ptr {w.emit(f'getelementptr {word}, ptr %results, i64 {i}')}, align 8")
    return entry(w, name, ["ptr %doubles", "ptr %integers", "ptr %results"]), shape


def translated(function: Any, kinds: Callable[[Program], Sequence[Type]]) -> Function:
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


def called(w: Values, function: Function, given: Sequence[str]) -> str:
    """What a function returns; the entry ends where it raises an exception."""
    name, kind, fails = w.module.name(function), w.module.type(function.returns), w.module.fails(function)
    call = f"call {kind} {name}({', '.join([*given, *['ptr %failed'] * fails])})"
    if fails:
        w.slots += ["  %failed = alloca i1", "  store i1 false, ptr %failed"]
    found = ""
    if kind == "void":
        w.line(call)
    else:
        found = w.emit(call)
    if fails:
        w.require(w.emit(f"xor i1 {w.emit('load i1, ptr %failed')}, true"))
    return found


def entry(w: Values, name: str, taken: Sequence[str]) -> str:
    """The whole text: a function that returns 0, or 1 where it raises."""
    w.line("ret i32 0")
    raised = ["raised:", "  ret i32 1"] if w.failed else []
    lines = [
        f"define i32 @{name}({', '.join(taken)}) nounwind {{",
        "entry:",
        *w.slots,
        *w.lines,
        *raised,
        "}",
    ]
    return w.module.text("\n".join(lines))


def kind_of(program: Program, shape: Any) -> Type:
    """The type of an argument of a shape."""
    if isinstance(shape, tuple):
        cls, *parts = shape
        if cls is Array:
            return Array(*parts)
        if cls is Known:
            return Known(*parts)
        names = getattr(cls, "_fields", [f"value_{i}" for i in range(1, len(parts) + 1)])
        kinds = {name: kind_of(program, part) for name, part in zip(names, parts, strict=True)}
        return program.record(None if cls is tuple else cls, kinds, snake(cls.__name__))
    if shape not in TYPES:
        raise TranslationError(f"compiled code does not take a {shape.__name__}")
    return TYPES[shape]


class Arguments:
    """Reads arguments from memory."""

    def __init__(self, body: Values) -> None:
        self.body = body
        self.doubles = self.integers = 0

    def value(self, kind: Type) -> str:
        """What stands for an argument of a type."""
        w = self.body
        if isinstance(kind, Record):
            return w.made(kind, [self.value(part) for part in fields_of(kind).values()])
        if isinstance(kind, Array):
            found = w.emit(f"inttoptr i64 {self.integer()} to ptr")
            found = w.emit(f"insertvalue {w.module.type(kind)} poison, ptr {found}, 0")
            for axis in range(len(kind.lengths)):
                found = w.emit(f"insertvalue {w.module.type(kind)} {found}, i64 {self.integer()}, {axis + 1}")
            return found
        if kind == REAL:
            self.doubles += 1
            return self.loaded("double", f"ptr %doubles, i64 {self.doubles - 1}")
        return self.integer() if kind == INT else w.emit(f"icmp ne i64 {self.integer()}, 0")

    def integer(self) -> str:
        self.integers += 1
        return self.loaded("i64", f"ptr %integers, i64 {self.integers - 1}")

    def loaded(self, word: str, place: str) -> str:
        return self.body.emit(f"load {word}, ptr {self.body.emit(f'getelementptr {word}, {place}')}, align 8")


def gathered(w: Values, kind: Type, value: str, numbers: list[tuple[Type, str]]) -> Any:
    """The shape of a value, whose numbers go into a list."""
    if isinstance(kind, Record):
        kept, shapes = list(fields_of(kind)), []
        for name, part in kind.fields.items():
            inner = (
                ""
                if name not in kept
                else w.emit(f"extractvalue {w.module.type(kind)} {value}, {kept.index(name)}")
            )
            shapes.append(gathered(w, part, inner, numbers))
        return (kind.cls or tuple, *shapes)
    if isinstance(kind, Known):
        return (Known, kind.value)
    if kind not in NUMBERS:
        raise CompileError("compiled code cannot return an array")
    numbers.append((kind, value))
    return PYTHON_TYPES[kind]
