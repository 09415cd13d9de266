"""Expressions: names, fields, operators and choices."""

import ast
from collections.abc import Callable, Sequence
from contextlib import suppress
from types import FunctionType, ModuleType
from typing import Any

from hydroservo.engine.lower import numbers
from hydroservo.engine.lower.frame import Frame, allowed, lowers
from hydroservo.engine.lower.memory import item
from hydroservo.engine.lower.values import Array, Bound, LoweringError, Record, Scalar, lifted, same
from hydroservo.engine.lower.writer import Block, DeadEndError, said

NO_MEMORY = "a list, a dict or a string needs memory, which compiled code does not have"


@lowers(ast.Constant)
def constant(_: Frame, node: ast.Constant) -> Any:
    return node.value


@lowers(ast.Name)
def name(frame: Frame, node: ast.Name) -> Any:
    return frame.named(node.id)


@lowers(ast.Attribute)
def attribute(frame: Frame, node: ast.Attribute) -> Any:
    owner = frame.value(node.value)
    if isinstance(owner, Record):
        return part_of(owner, node.attr)
    if isinstance(owner, Array) and node.attr in ARRAYS:
        return ARRAYS[node.attr](frame, owner)
    if isinstance(owner, type | ModuleType) and hasattr(owner, node.attr):
        found = getattr(owner, node.attr)
        if isinstance(found, FunctionType) and isinstance(owner, ModuleType):
            allowed(node.attr, found)
        return lifted(found)
    frame.line = node.lineno
    raise LoweringError(f"{said(owner)} has no {node.attr}")


def part_of(owner: Record, name: str) -> Any:
    """A field of a block, or a method."""
    fields = getattr(owner.cls, "_fields", ())
    if name in fields:
        return owner.parts[fields.index(name)]
    method = vars(owner.cls).get(name)
    if not isinstance(method, FunctionType):
        raise LoweringError(f"{name} is neither a field nor a method of {owner.cls.__name__}")
    return Bound(method, owner)


def size(frame: Frame, array: Array) -> Any:
    """How many numbers an array has."""
    total: Any = 1
    for length in array.lengths:
        total = numbers.binary(frame.writer, ast.Mult, total, length)
    return total


ARRAYS: dict[str, Callable[[Frame, Array], Any]] = {
    "size": size,
    "shape": lambda _, array: Record(tuple, array.lengths),
    "ndim": lambda _, array: len(array.lengths),
}


@lowers(ast.Tuple)
def tuple_(frame: Frame, node: ast.Tuple) -> Record:
    return Record(tuple, spread(frame, node.elts))


def spread(frame: Frame, nodes: Sequence[ast.expr]) -> list[Any]:
    """Values in a row, those of tuples and lists that are unpacked among them."""
    values: list[Any] = []
    for node in nodes:
        values += unpack(frame, node.value) if isinstance(node, ast.Starred) else [frame.value(node)]
    return values


def unpack(frame: Frame, node: ast.expr) -> list[Any]:
    """The values of a tuple, or of a list whose length is known, such as ``[0.0] * 120``."""
    match node:
        case ast.List(elts=elements):
            return spread(frame, elements)
        case ast.BinOp(left=ast.List() | ast.Tuple() as left, op=ast.Mult(), right=right):
            count = frame.value(right)
            if type(count) is int:
                return unpack(frame, left) * count
    several = frame.value(node)
    if not isinstance(several, Record):
        raise LoweringError(f"compiled code cannot unpack {said(several)}")
    return list(several.parts)


@lowers(ast.Subscript)
def subscript(frame: Frame, node: ast.Subscript) -> Any:
    owner = frame.value(node.value)
    if isinstance(node.slice, ast.Slice):
        bounds = [
            None if one is None else frame.value(one)
            for one in (node.slice.lower, node.slice.upper, node.slice.step)
        ]
        if isinstance(owner, Record) and not any(isinstance(bound, Scalar) for bound in bounds):
            return Record(tuple, owner.parts[slice(*bounds)])
        raise LoweringError(f"compiled code cannot slice {said(owner)}")
    return item(frame.writer, owner, frame.value(node.slice))


@lowers(ast.BinOp)
def operator(frame: Frame, node: ast.BinOp) -> Any:
    a, b = frame.value(node.left), frame.value(node.right)
    if isinstance(a, Record) and isinstance(b, Record) and isinstance(node.op, ast.Add):
        return Record(tuple, (*a.parts, *b.parts))
    return numbers.binary(frame.writer, type(node.op), a, b)


@lowers(ast.UnaryOp)
def unary(frame: Frame, node: ast.UnaryOp) -> Any:
    value = frame.value(node.operand)
    if isinstance(node.op, ast.Not):
        return numbers.inverted(frame.writer, value)
    if isinstance(node.op, ast.USub):
        return numbers.negated(frame.writer, value)
    if isinstance(node.op, ast.Invert):
        return numbers.binary(frame.writer, ast.BitXor, numbers.whole(frame.writer, value), -1)
    return numbers.binary(frame.writer, ast.Add, 0, value)


@lowers(ast.Compare)
def comparison(frame: Frame, node: ast.Compare) -> Any:
    steps = list(zip(node.ops, node.comparators, strict=True))

    def further(left: Any, i: int) -> Any:
        op, right = steps[i][0], frame.value(steps[i][1])
        found = single(frame, op, left, right)
        if i + 1 == len(steps):
            return found
        return chosen(frame, found, lambda: further(right, i + 1), lambda: False)

    return further(frame.value(node.left), 0)


def single(frame: Frame, op: ast.cmpop, a: Any, b: Any) -> Any:
    """Whether two values compare so."""
    if isinstance(op, ast.Is | ast.IsNot):
        if isinstance(a, Scalar) and isinstance(b, Scalar | bool):
            raise LoweringError("compiled code does not know whether two numbers are one object")
        return same(a, b) is isinstance(op, ast.Is)
    if type(a) is type(b) and isinstance(a, str | type | None) and isinstance(op, ast.Eq | ast.NotEq):
        return (a == b) is isinstance(op, ast.Eq)
    if isinstance(op, ast.In | ast.NotIn):
        if not isinstance(b, Record):
            raise LoweringError(f"compiled code cannot search {said(b)}")
        found: Any = False
        for part in b.parts:
            found = numbers.binary(
                frame.writer, ast.BitOr, found, numbers.compared(frame.writer, ast.Eq, a, part)
            )
        return numbers.inverted(frame.writer, found) if isinstance(op, ast.NotIn) else found
    return numbers.compared(frame.writer, type(op), a, b)


@lowers(ast.BoolOp)
def logic(frame: Frame, node: ast.BoolOp) -> Any:
    def further(i: int) -> Any:
        value = frame.value(node.values[i])
        if i + 1 == len(node.values):
            return value
        rest = lambda: further(i + 1)  # noqa: E731 - one of two
        if isinstance(node.op, ast.And):
            return chosen(frame, value, rest, lambda: value)
        return chosen(frame, value, lambda: value, rest)

    return further(0)


@lowers(ast.IfExp)
def choice(frame: Frame, node: ast.IfExp) -> Any:
    condition = frame.value(node.test)
    return chosen(frame, condition, lambda: frame.value(node.body), lambda: frame.value(node.orelse))


def chosen(frame: Frame, condition: Any, then: Callable[[], Any], otherwise: Callable[[], Any]) -> Any:
    """One of two values, of which only that one is computed."""
    w = frame.writer
    known = numbers.truth(w, condition)
    if not isinstance(known, Scalar):
        return then() if known else otherwise()
    start, blocks = w.here, (w.block(), w.block())
    ends: list[tuple[Block, Any]] = []
    for block, value in zip(blocks, (then, otherwise), strict=True):
        w.enter(block)
        with suppress(DeadEndError):
            found = value()
            ends.append((w.end, found))
    w.here = start
    if [block for block, _ in ends] == list(blocks) and not any(block.lines for block in blocks):
        del w.blocks[w.blocks.index(blocks[0]) :]
        return w.selected(known, ends[0][1], ends[1][1])
    w.choose(known, *blocks)
    return w.meet(ends)


def needs_memory(_: Frame, __: ast.expr) -> Any:
    raise LoweringError(NO_MEMORY)


for _kind in (
    ast.List,
    ast.Dict,
    ast.Set,
    ast.ListComp,
    ast.DictComp,
    ast.SetComp,
    ast.GeneratorExp,
    ast.JoinedStr,
):
    lowers(_kind)(needs_memory)
