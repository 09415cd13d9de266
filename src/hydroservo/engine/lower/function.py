"""One LLVM function from a function of Python and all that it calls."""

from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.engine.lower import calls  # noqa: F401 - lowers calls
from hydroservo.engine.lower.frame import Frame, inlined
from hydroservo.engine.lower.memory import loaded, stored
from hydroservo.engine.lower.values import (
    ADDRESS,
    BOOL,
    DOUBLE,
    INTEGER,
    PYTHON_TYPES,
    Array,
    Composite,
    LoweringError,
    Pointer,
    Record,
    Scalar,
    is_number,
    kind_of,
)
from hydroservo.engine.lower.writer import DeadEndError, Writer, said
from hydroservo.engine.native import CompileError

FLOAT = DOUBLE
DOUBLES = "double*"  # memory of them
INTEGERS = "i64*"


def kernel_text(name: str, function: Callable[..., Any], kinds: Sequence[str]) -> str:
    """The module of a function of numbers and memory that returns a whole number, as ``Native`` calls it."""
    given = [argument(kind, f"%a{i}") for i, kind in enumerate(kinds)]
    asked = "".join(f", {kind} %a{i}" for i, kind in enumerate(types_of(kinds)))

    def write(w: Writer, stack: list[Frame]) -> None:
        found = inlined(w, function, given, {}, stack)
        stored(w, INTEGER, "%result", 0, w.converted(found, INTEGER))

    return module(name, f"ptr %result{asked}", write)


def types_of(kinds: Sequence[str]) -> list[str]:
    """LLVM's types of arguments."""
    return [ADDRESS if kind.endswith("*") else kind for kind in kinds]


def argument(kind: str, name: str) -> Any:
    return Pointer(kind[:-1], name) if kind.endswith("*") else Scalar(kind, name)


class Asked:
    """The arguments of a function in memory: floats in a row of doubles, all else in one of integers."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        self.doubles = self.integers = 0

    def value(self, shape: Any) -> Any:
        """What stands for an argument of a shape.

        Raises:
            LoweringError: nothing does.
        """
        if isinstance(shape, tuple):
            cls, *parts = shape
            if cls is Array:
                address = self.value(int)
                start = self.writer.emit(ADDRESS, f"inttoptr i64 {address.text} to ptr")
                return Array([start, *(self.value(int) for _ in range(*parts))])
            return Record(cls, [self.value(part) for part in parts])
        if shape is float:
            self.doubles += 1
            return loaded(self.writer, DOUBLE, "%doubles", self.doubles - 1)
        if shape not in (int, bool):
            raise LoweringError(f"compiled code takes no {shape.__name__}")
        self.integers += 1
        found = loaded(self.writer, INTEGER, "%integers", self.integers - 1)
        return found if shape is int else self.writer.emit(BOOL, f"icmp ne i64 {found.text}, 0")


def method_text(name: str, function: Callable[..., Any], shapes: Sequence[Any]) -> tuple[str, Any]:
    """The module of a function of blocks and numbers, and the shape of what it returns."""
    made: list[Any] = []

    def write(w: Writer, stack: list[Frame]) -> None:
        asked = Asked(w)
        found = inlined(w, function, [asked.value(shape) for shape in shapes], {}, stack)
        numbers: list[Any] = []
        made.append(gathered(found, numbers))
        for i, number in enumerate(numbers):
            whole = DOUBLE if kind_of(number) == DOUBLE else INTEGER
            stored(w, whole, "%results", i, w.converted(number, whole))

    text = module(name, "ptr %doubles, ptr %integers, ptr %results", write)
    return text, made[0] if made else type(None)


def gathered(value: Any, numbers: list[Any]) -> Any:
    """The shape of a value, whose numbers go into a list."""
    if isinstance(value, Record):
        return (value.cls, *(gathered(part, numbers) for part in value.parts))
    if value is None:
        return type(None)
    if isinstance(value, Composite) or not is_number(value):
        raise LoweringError(f"compiled code cannot return {said(value)}")
    numbers.append(value)
    return PYTHON_TYPES[kind_of(value)]


def module(name: str, asked: str, write: Callable[[Writer, list[Frame]], None]) -> str:
    """The text of a module with one function, which returns 0, or 1 where it raises."""
    w, stack = Writer(), list[Frame]()
    try:
        write(w, stack)
        w.line("ret i32 0")
    except DeadEndError:
        pass
    except (LoweringError, RecursionError) as error:
        if not isinstance(error, LoweringError):
            error = LoweringError("its expressions or calls nest too deeply", "give parts of them names")
        raise CompileError(f"{error}; {error.hint}", [frame.place for frame in reversed(stack)]) from None
    if w.raised is not None:
        w.raised.lines.append("ret i32 1")
    lines = [*w.declared.values(), "", f"define i32 @{name}({asked}) nounwind {{", w.body(), "}"]
    return "\n".join([*lines, *loop_nodes(w.loops)]) + "\n"


def loop_nodes(few: Sequence[bool]) -> list[str]:
    """A node for each loop: those with few turns are unrolled, the others ask for what node 0 says."""
    unrolled = len(few) + 1
    nodes = [f"!{i} = distinct !{{!{i}, !{unrolled if one else 0}}}" for i, one in enumerate(few, start=1)]
    return [*nodes, f'!{unrolled} = !{{!"llvm.loop.unroll.full"}}']
