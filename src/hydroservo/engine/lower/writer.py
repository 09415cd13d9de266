"""Writes the basic blocks of an LLVM function."""

from collections.abc import Sequence
from typing import Any

from hydroservo.engine.lower.values import (
    BOOL,
    DOUBLE,
    INTEGER,
    Composite,
    LoweringError,
    Record,
    Scalar,
    is_number,
    kind_of,
    operand,
    same,
    unified,
)

Mark = tuple[int, "Block", int, int]


class DeadEndError(Exception):
    """Nothing goes on after what was lowered: it raises."""


class Block:
    """A basic block: its label, its phis and its lines, the last one leaving it."""

    __slots__ = ("label", "lines", "phis")

    def __init__(self, label: str) -> None:
        self.label = label
        self.phis: list[str] = []
        self.lines: list[str] = []


class Writer:
    """The text of a function while it grows.

    Attributes:
        here: the block that is written; None after what never ends.
        declared: the functions that it calls.
        loops: of each loop, whether it has few turns.
    """

    def __init__(self) -> None:
        self.blocks: list[Block] = []
        self.declared: dict[str, str] = {}
        self.count = 0
        self.loops: list[bool] = []
        self.raised: Block | None = None
        self.here: Block | None = None
        self.enter(self.block())

    def block(self) -> Block:
        """A new block, which stands nowhere yet."""
        self.count += 1
        return Block(f"b{self.count}")

    def enter(self, block: Block) -> None:
        """Goes on in a new block."""
        self.blocks.append(block)
        self.here = block

    def fresh(self, kind: str) -> Scalar:
        """A new name."""
        self.count += 1
        return Scalar(kind, f"%v{self.count}")

    @property
    def end(self) -> Block:
        """The block that is written."""
        if self.here is None:
            raise DeadEndError
        return self.here

    def line(self, text: str) -> None:
        """A line of text in this block."""
        self.end.lines.append(text)

    def emit(self, kind: str, text: str) -> Scalar:
        """A new number by an instruction."""
        found = self.fresh(kind)
        self.line(f"{found.text} = {text}")
        return found

    def call(self, name: str, kind: str, arguments: Sequence[Any]) -> Scalar:
        """What a function of LLVM or of the C library returns for numbers."""
        kinds = ", ".join(map(kind_of, arguments))
        self.declared[name] = f"declare {kind} @{name}({kinds})"
        given = ", ".join(f"{kind_of(value)} {operand(value)}" for value in arguments)
        return self.emit(kind, f"call {kind} @{name}({given})")

    def branch(self, target: Block) -> None:
        """Leaves this block."""
        self.line(f"br label %{target.label}")
        self.here = None

    def choose(self, condition: Scalar, then: Block, otherwise: Block) -> None:
        """Leaves this block for one of two."""
        self.line(f"br i1 {condition.text}, label %{then.label}, label %{otherwise.label}")
        self.here = None

    def loop_back(self, target: Block, few: bool) -> None:
        """Leaves this block for the head of the loop that it ends, which may have few turns."""
        self.loops.append(few)
        self.line(f"br label %{target.label}, !llvm.loop !{len(self.loops)}")
        self.here = None

    def stop(self) -> None:
        """Leaves this block, and the function, with an exception."""
        self.branch(self.exception())

    def require(self, condition: Any) -> None:
        """An exception unless the condition holds."""
        if condition is True:
            return
        if condition is False:
            self.stop()
            return
        further = self.block()
        self.choose(condition, further, self.exception())
        self.enter(further)

    def exception(self) -> Block:
        """Where a function ends that raised an exception."""
        if self.raised is None:
            self.raised = Block("raised")
        return self.raised

    def mark(self) -> Mark:
        """Where the text ends now."""
        return len(self.blocks), self.end, len(self.end.lines), self.count

    def rewind(self, mark: Mark) -> None:
        """Takes back what was written after a mark."""
        blocks, self.here, lines, self.count = mark
        del self.blocks[blocks:], self.here.lines[lines:]

    def converted(self, value: Any, kind: str) -> Any:
        """A number as one of another kind, which holds it."""
        own = kind_of(value)
        if own == kind:
            return value
        if not isinstance(value, Scalar):
            return float(value) if kind == DOUBLE else int(value)
        instruction = "zext" if kind == INTEGER else "uitofp" if own == BOOL else "sitofp"
        return self.emit(kind, f"{instruction} {own} {value.text} to {kind}")

    def selected(self, condition: Scalar, a: Any, b: Any) -> Any:
        """One of two values of one structure, without a branch."""
        if same(a, b):
            return a
        if isinstance(a, Composite) and a.like(b):
            return a.with_parts(
                [self.selected(condition, *pair) for pair in zip(a.parts, b.parts, strict=True)]
            )
        kind = common_kind([a, b])
        x, y = (operand(self.converted(value, kind)) for value in (a, b))
        return self.emit(kind, f"select i1 {condition.text}, {kind} {x}, {kind} {y}")

    def phi(self, target: Block, ends: Sequence[Block], values: Sequence[Any]) -> Any:
        """In a block that others end in, the value that comes with the one that it was reached from."""
        first = values[0]
        if all(same(first, value) for value in values):
            return first
        if isinstance(first, Composite) and all(map(first.like, values)):
            columns = zip(*(value.parts for value in values), strict=True)
            return first.with_parts([self.phi(target, ends, column) for column in columns])
        kind = common_kind(values)
        found = self.fresh(kind)
        target.phis.append(f"{found.text} = phi {kind} {', '.join(map(self.incoming(kind), values, ends))}")
        return found

    def meet(self, ends: Sequence[tuple[Block, Any]]) -> Any:
        """Goes on where blocks end, each with its value; returns the value there."""
        if not ends:
            raise DeadEndError
        if len(ends) == 1:
            self.here, value = ends[0]
            return value
        target, blocks = self.block(), [block for block, _ in ends]
        value = self.phi(target, blocks, [value for _, value in ends])
        for block in blocks:
            self.here = block
            self.branch(target)
        self.enter(target)
        return value

    def incoming(self, kind: str) -> Any:
        """What gives the text of a phi's value from a block that is not left yet."""

        def text(value: Any, end: Block) -> str:
            self.here = end
            return f"[ {operand(self.converted(value, kind))}, %{end.label} ]"

        return text

    def body(self) -> str:
        """All blocks."""
        blocks = [*self.blocks, *([self.raised] if self.raised else [])]
        return "\n".join("\n  ".join([f"{block.label}:", *block.phis, *block.lines]) for block in blocks)


def common_kind(values: Sequence[Any]) -> str:
    """The kind that all of some numbers can have."""
    if all(is_number(value) or isinstance(value, Scalar) for value in values):
        return unified([kind_of(value) for value in values])
    raise LoweringError(f"{' or '.join(dict.fromkeys(map(said, values)))} under one name")


def said(value: Any) -> str:
    """What a value is called in a message."""
    if is_number(value):
        return {DOUBLE: "a float", INTEGER: "an int", BOOL: "a bool"}[kind_of(value)]
    if isinstance(value, Record):
        return (
            f"a {value.cls.__name__} of {len(value.parts)}"
            if value.cls is tuple
            else f"a {value.cls.__name__}"
        )
    if isinstance(value, Composite):
        return "an array"
    return "None" if value is None else f"a {type(value).__name__}"
