"""Translates expressions of Python."""

import ast
import builtins
import math
from collections.abc import Sequence
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

from hydroservo.export.arithmetic import Arithmetic
from hydroservo.export.bindings import bound_names
from hydroservo.export.calls import Calls
from hydroservo.export.names import identifier
from hydroservo.export.scope import Scope, Value
from hydroservo.export.terms import (
    BOOL,
    REAL,
    Bound,
    Constant,
    Element,
    Expression,
    Known,
    Literal,
    Member,
    Python,
    Record,
    Several,
    Table,
    Variable,
)

if TYPE_CHECKING:
    from hydroservo.export.translate import Translator

__all__ = ["Expressions"]

INHERITED = {"_asdict", "_make", "_replace"}  # what every NamedTuple class has


class Expressions:
    """The expressions of one function.

    Every method raises :class:`TranslationError` where C has no equal.
    """

    def __init__(self, translator: "Translator", scope: Scope) -> None:
        self.scope, self.arithmetic = scope, Arithmetic(scope)
        self.calls = Calls(translator, scope, self.arithmetic)

    def expression(self, node: ast.expr) -> Value:
        match node:
            case ast.Constant(value=value):
                return self.constant(value, node)
            case ast.Name(id=name):
                return self.named(name, node)
            case ast.Attribute(value=value, attr=name):
                return self.attribute(self.expression(value), name, node)
            case ast.Call():
                return self.call(node)
            case ast.BinOp(left=left, op=op, right=right):
                return self.arithmetic.binary(op, self.expression(left), self.expression(right), node)
            case ast.UnaryOp(op=op, operand=operand):
                return self.unary(op, operand, node)
            case ast.Compare() | ast.BoolOp():
                return self.condition(node)
            case ast.IfExp(test=test, body=body, orelse=otherwise):
                condition = self.condition(test)
                if isinstance(condition, Known):
                    return self.expression(body if condition.value else otherwise)
                return self.arithmetic.choice(
                    condition, self.expression(body), self.expression(otherwise), node
                )
            case ast.Subscript(value=value, slice=index):
                return self.element(self.expression(value), index, node)
            case ast.Tuple(elts=elements):
                return self.several(elements)
        raise self.scope.error(f"{ast.unparse(node)!r} has no equal in C here", node)

    def several(self, elements: Sequence[ast.expr]) -> Several:
        names: list[str] = []
        for i, element in enumerate(elements):
            name = identifier(element.id) if isinstance(element, ast.Name) else f"value_{i + 1}"
            names.append(name if name not in names else f"value_{i + 1}")
        return Several(tuple(self.expression(element) for element in elements), tuple(names))

    def constant(self, value: object, node: ast.AST) -> Value:
        if isinstance(value, (bool, int)):
            return Known(value)
        if isinstance(value, float):
            return Literal(REAL, value)
        way_out = "use math.nan or math.inf" if value in ("nan", "inf", "-inf") else "use numbers"
        raise self.scope.error(f"{value!r} is neither a number nor a truth value", node, way_out)

    def named(self, name: str, node: ast.AST) -> Value:
        if name in self.scope.environment:
            value = self.scope.environment[name]
            if isinstance(value, Variable) and value.mutable and value.name not in self.scope.certain:
                raise self.scope.error(f"{name} may have no value yet", node, "give it one on every path")
            return value
        if name in self.scope.changing or name in bound_names(self.scope.tree):
            raise self.scope.error(f"{name} may have no value yet", node, "give it one on every path")
        namespace = self.scope.origin.__globals__
        if name in namespace:
            return self.python(namespace[name], name, self.scope.origin.__module__, node)
        if hasattr(builtins, name):
            return Python(getattr(builtins, name))
        raise self.scope.error(f"{name} is not defined", node)

    def python(self, thing: Any, name: str, module: str, node: ast.AST) -> Value:
        """Something that a module holds."""
        if isinstance(thing, (bool, int)):
            return Known(thing)
        if isinstance(thing, float):
            special = not math.isfinite(thing)
            return Literal(REAL, thing) if special else Constant(REAL, module, name, thing)
        if callable(thing) or isinstance(thing, ModuleType):
            return Python(thing)
        raise self.scope.error(
            f"{name} is a {type(thing).__name__}, which a law cannot use", node, "use floats and blocks"
        )

    def attribute(self, base: Value, name: str, node: ast.AST) -> Value:
        if isinstance(base, Python):
            if not isinstance(base.thing, ModuleType) or not hasattr(base.thing, name):
                raise self.scope.error(f"{ast.unparse(node)} is not there", node)
            return self.python(getattr(base.thing, name), name, base.thing.__name__, node)
        if isinstance(base, Table) and name == "size":
            return Known(base.array.size)
        if isinstance(base, Expression) and isinstance(base.type, Record):
            if name in base.type.fields:
                return self.member(self.scope.lasting(base), name)
            return self.method(base, base.type, name, node)
        raise self.scope.error(f"{ast.unparse(node)!r} has no equal in C", node)

    def method(self, base: Expression, record: Record, name: str, node: ast.AST) -> Bound:
        """A method that a record's class has itself."""
        cls = record.cls
        found = vars(cls).get(name) if cls else None
        if isinstance(found, FunctionType) and name not in INHERITED:
            return Bound(base, found)
        called = cls.__name__ if cls else record.name
        if cls is not None and hasattr(cls, name):
            what = type(found).__name__ if found is not None and name not in INHERITED else "inherited"
            problem = f"{name} of {called} is no method of its own ({what})"
            raise self.scope.error(problem, node, "write it as a plain method of the class")
        raise self.scope.error(f"{called} has neither a field nor a method {name!r}", node)

    def member(self, base: Expression, name: str) -> Value:
        kind = base.type.fields[name]  # type: ignore[union-attr]
        return kind if isinstance(kind, (Known, Table)) else Member(kind, base, name)

    def element(self, table: Value, index: ast.expr, node: ast.AST) -> Value:
        if not isinstance(table, Table):
            raise self.scope.error("only the arrays of recorded signals can be indexed", node)
        parts = index.elts if isinstance(index, ast.Tuple) else [index]
        if len(parts) != table.array.ndim:
            raise self.scope.error(f"this array takes {table.array.ndim} indices", node)
        total: Value = Known(0)
        for part, length in zip(parts, table.array.shape, strict=True):
            found = self.expression(part)
            if isinstance(found, Known) and not -length <= found.value < length:
                raise self.scope.error(f"the index {found.value} is out of the array's {length}", node)
            if isinstance(found, Known) and found.value < 0:
                found = Known(found.value + length)
            scaled = self.arithmetic.binary(ast.Mult(), total, Known(length), node)
            total = found if scaled == Known(0) else self.arithmetic.binary(ast.Add(), scaled, found, node)
        return Element(REAL, table, total)

    def unary(self, op: ast.unaryop, operand: ast.expr, node: ast.AST) -> Value:
        if isinstance(op, ast.Not):
            return self.arithmetic.negated(self.condition(operand))
        if isinstance(op, ast.USub):
            return self.arithmetic.negative(self.expression(operand), node)
        raise self.scope.error("this operation has no equal in C", node)

    def condition(self, node: ast.expr) -> Expression | Known:
        """A truth value."""
        match node:
            case ast.Compare(left=left, ops=operators, comparators=rest):
                values = [self.expression(one) for one in (left, *rest)]
                pairs = zip(values, operators, values[1:], strict=False)
                return self.arithmetic.joined("&&", [self.arithmetic.comparison(*one, node) for one in pairs])
            case ast.BoolOp(op=op, values=parts):
                sign = "&&" if isinstance(op, ast.And) else "||"
                return self.arithmetic.joined(sign, [self.condition(part) for part in parts])
        value = self.expression(node)
        known = isinstance(value, Known) and isinstance(value.value, bool)
        if known or (isinstance(value, Expression) and value.type == BOOL):
            return value  # type: ignore[return-value]
        raise self.scope.error(f"{ast.unparse(node)!r} is a number, not a truth value", node, "compare it")

    def call(self, node: ast.Call) -> Value:
        starred = any(isinstance(one, ast.Starred) for one in node.args)
        if starred or any(one.arg is None for one in node.keywords):
            raise self.scope.error("arguments with * cannot be translated to C", node, "name each of them")
        target = self.expression(node.func)
        given = [self.expression(one) for one in node.args]
        named = {str(one.arg): self.expression(one.value) for one in node.keywords}
        return self.calls.call(target, given, named, node)

    def kept(self, value: Expression) -> Expression:
        """A record as it is now, where it may change later."""
        base = value
        while isinstance(base, Member):
            base = base.base
        if isinstance(base, Variable) and not base.mutable:
            return value
        named = self.scope.let(self.scope.fresh("record"), value)
        return named if isinstance(named, Expression) else value
