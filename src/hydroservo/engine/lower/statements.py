"""Statements that give names a value, choose, or end a call."""

import ast
from typing import Any

from hydroservo.engine.lower import numbers
from hydroservo.engine.lower.frame import End, Frame, lowers
from hydroservo.engine.lower.memory import item, put
from hydroservo.engine.lower.values import LoweringError, Record, Scalar
from hydroservo.engine.lower.writer import said


@lowers(ast.Pass)
def pass_(_: Frame, __: ast.Pass) -> None:
    """Nothing."""


@lowers(ast.Expr)
def expression(frame: Frame, node: ast.Expr) -> None:
    if not isinstance(node.value, ast.Constant):
        frame.value(node.value)


@lowers(ast.Assign)
def assignment(frame: Frame, node: ast.Assign) -> None:
    value = frame.value(node.value)
    for target in node.targets:
        bind(frame, target, value)


@lowers(ast.AnnAssign)
def annotated(frame: Frame, node: ast.AnnAssign) -> None:
    if node.value is not None:
        bind(frame, node.target, frame.value(node.value))


@lowers(ast.AugAssign)
def augmented(frame: Frame, node: ast.AugAssign) -> None:
    if isinstance(node.target, ast.Name):
        old = frame.named(node.target.id)
        new = numbers.binary(frame.writer, type(node.op), old, frame.value(node.value))
        frame.env[node.target.id] = new
    elif isinstance(node.target, ast.Subscript):
        owner, index = frame.value(node.target.value), frame.value(node.target.slice)
        old = item(frame.writer, owner, index)
        new = numbers.binary(frame.writer, type(node.op), old, frame.value(node.value))
        put(frame.writer, owner, index, new)
    else:
        raise LoweringError("a block's fields keep their values")


def bind(frame: Frame, target: ast.expr, value: Any) -> None:
    """Gives a name, names in a row or a place in memory a value."""
    if isinstance(target, ast.Name):
        frame.env[target.id] = value
    elif isinstance(target, ast.Tuple | ast.List):
        if not isinstance(value, Record):
            raise LoweringError(f"compiled code cannot unpack {said(value)}")
        if len(value.parts) != len(target.elts):
            raise LoweringError(f"{len(target.elts)} names for {len(value.parts)} values")
        for one, part in zip(target.elts, value.parts, strict=True):
            bind(frame, one, part)
    elif isinstance(target, ast.Subscript):
        put(frame.writer, frame.value(target.value), frame.value(target.slice), value)
    else:
        raise LoweringError("a block's fields keep their values")


@lowers(ast.Return)
def return_(frame: Frame, node: ast.Return) -> None:
    value = None if node.value is None else frame.value(node.value)
    frame.returns.append((frame.writer.end, value))
    frame.writer.here = None


@lowers(ast.Raise)
def raise_(frame: Frame, _: ast.Raise) -> None:
    frame.writer.stop()


@lowers(ast.Assert)
def assert_(frame: Frame, node: ast.Assert) -> None:
    frame.writer.require(numbers.truth(frame.writer, frame.value(node.test)))


@lowers(ast.If)
def if_(frame: Frame, node: ast.If) -> None:
    w = frame.writer
    condition = numbers.truth(w, frame.value(node.test))
    if not isinstance(condition, Scalar):
        frame.run(node.body if condition else node.orelse)
        return
    blocks, env = (w.block(), w.block()), frame.env
    w.choose(condition, *blocks)
    ends: list[End] = []
    for block, body in zip(blocks, (node.body, node.orelse), strict=True):
        w.enter(block)
        frame.env = dict(env)
        frame.run(body)
        if w.here is not None:
            ends.append((w.here, frame.env))
    frame.join(ends)
