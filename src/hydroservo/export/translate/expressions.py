"""Translates expressions of Python."""

import ast
import builtins
import math
from collections.abc import Sequence
from numbers import Number
from types import ModuleType
from typing import Any

import numpy as np

from hydroservo.block import is_block
from hydroservo.export.names import identifier
from hydroservo.export.translate.arithmetic import Arithmetic
from hydroservo.export.translate.bindings import Binding
from hydroservo.export.translate.calls import Calls
from hydroservo.export.translate.definition import DoubtError, own_method
from hydroservo.export.translate.scope import Scope, Value
from hydroservo.export.translate.terms import (
    BOOL,
    INT,
    REAL,
    Assign,
    Bound,
    Constant,
    Element,
    Expression,
    If,
    Known,
    Literal,
    Member,
    Python,
    Record,
    Several,
    Statement,
    Table,
    Translator,
    Unary,
    Variable,
)


class Expressions:
    """The expressions of one function.

    Every method raises :class:`TranslationError` where C has no equal.
    """

    def __init__(self, translator: Translator, scope: Scope) -> None:
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
                return self.chosen(condition, body, otherwise, node)
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
        """What a name stands for where a node reads it."""
        binding = self.scope.bindings.read(node)
        if binding is not None and binding in self.scope.environment:
            return self.local(binding, node)
        if name in self.scope.bindings.bound:
            raise self.scope.error(f"{name} may have no value yet", node, "give it one on every path")
        if name.startswith("__"):
            raise self.scope.error(f"{name} is a name that Python changes", node, "take another one")
        namespace = self.scope.origin.__globals__
        if name in namespace:
            return self.python(namespace[name], name, self.scope.origin.__module__, node)
        if hasattr(builtins, name):
            return Python(getattr(builtins, name))
        raise self.scope.error(f"{name} is not defined", node)

    def local(self, binding: Binding, node: ast.AST) -> Value:
        value = self.scope.environment[binding]
        if isinstance(value, Variable) and value.mutable and value.name not in self.scope.certain:
            problem = f"{binding.name} may have no value yet"
            raise self.scope.error(problem, node, "give it one on every path")
        return value

    def python(self, thing: Any, name: str, module: str, node: ast.AST) -> Value:
        """Something that a module holds."""
        if type(thing) in (bool, int):
            return Known(thing)
        if type(thing) is float or isinstance(thing, np.float64):  # whose arithmetic is that of floats
            number = float(thing)
            special = not math.isfinite(number)
            return Literal(REAL, number) if special else Constant(REAL, module, name, number)
        if isinstance(thing, Number):
            problem = f"{name} is a {type(thing).__name__}, whose arithmetic C does not have"
            raise self.scope.error(problem, node, f"write {name} = float(...)")
        if is_block(thing):
            parts = [
                self.block_field(thing, field, f"{name}.{field}", module, node) for field in thing._fields
            ]
            return self.calls.made(type(thing), parts, {}, node)
        if callable(thing) or isinstance(thing, ModuleType):
            return Python(thing)
        raise self.scope.error(
            f"{name} is a {type(thing).__name__}, which a law cannot use", node, "use floats and blocks"
        )

    def block_field(self, block: Any, field: str, name: str, module: str, node: ast.AST) -> Value:
        """A field of a block that a module holds."""
        value = getattr(block, field)
        return Literal(REAL, value) if type(value) is float else self.python(value, name, module, node)

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
        if cls is None or not hasattr(cls, name):
            called = cls.__name__ if cls else record.name
            raise self.scope.error(f"{called} has neither a field nor a method {name!r}", node)
        try:
            return Bound(base, own_method(cls, name))
        except DoubtError as doubt:
            raise self.scope.error(str(doubt), node, "write it as a plain method of the class") from None

    def member(self, base: Expression, name: str) -> Value:
        kind = base.type.fields[name]  # type: ignore[union-attr]
        if isinstance(kind, Known) and not isinstance(kind.value, int):
            return Python(kind.value)
        return kind if isinstance(kind, (Known, Table)) else Member(kind, base, name)

    def element(self, table: Value, index: ast.expr, node: ast.AST) -> Value:
        if isinstance(table, Expression) and isinstance(table.type, Record):
            return self.record_entry(table, table.type, self.expression(index), node)
        if not isinstance(table, Table):
            raise self.scope.error("only vectors and arrays of recorded signals can be indexed", node)
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
            if isinstance(found, Expression):
                self.within(found, length, node)
            scaled = self.arithmetic.binary(ast.Mult(), total, Known(length), node)
            total = found if scaled == Known(0) else self.arithmetic.binary(ast.Add(), scaled, found, node)
        return Element(REAL, table, total)

    def record_entry(self, base: Expression, record: Record, index: Value, node: ast.AST) -> Value:
        """A field of a record by its number."""
        fields = list(record.fields)
        if not isinstance(index, Known):
            raise self.scope.error("C finds an entry of a record by a known number alone", node)
        if not -len(fields) <= index.value < len(fields):
            raise self.scope.error(f"the index {index.value} is out of the record's {len(fields)}", node)
        return self.member(self.scope.lasting(base), fields[index.value])

    def within(self, index: Expression, length: int, node: ast.AST) -> None:
        """Asks that an index that is found at run time is within an array; the house's own searches are."""
        if index.type != INT:
            raise self.scope.error("an index must be a whole number", node)
        if not self.scope.origin.__module__.startswith("hydroservo."):
            self.scope.limit(index, length - 1, node, least=0)

    def unary(self, op: ast.unaryop, operand: ast.expr, node: ast.AST) -> Value:
        if isinstance(op, ast.Not):
            return self.arithmetic.negated(self.condition(operand))
        if isinstance(op, ast.USub):
            return self.arithmetic.negative(self.expression(operand), node)
        raise self.scope.error("this operation has no equal in C", node)

    def condition(self, node: ast.expr) -> Expression | Known:
        """A truth value."""
        match node:
            case ast.Compare(left=left, ops=operators, comparators=[right, *rest]):
                values = [self.expression(left), self.expression(right), *map(self.plain, rest)]
                pairs = zip(values, operators, values[1:], strict=False)
                return self.arithmetic.joined("&&", [self.arithmetic.comparison(*one, node) for one in pairs])
            case ast.BoolOp(op=op, values=parts):
                return self.joined("&&" if isinstance(op, ast.And) else "||", parts)
        value = self.expression(node)
        known = isinstance(value, Known) and isinstance(value.value, bool)
        if known or (isinstance(value, Expression) and value.type == BOOL):
            return value  # type: ignore[return-value]
        raise self.scope.error(f"{ast.unparse(node)!r} is a number, not a truth value", node, "compare it")

    # what is computed only if something else holds

    def apart(self, node: ast.expr, as_condition: bool) -> tuple[Value, list[Statement]]:
        """A value, and the statements that must run before it."""
        outer, self.scope.block = self.scope.block, []
        value = self.condition(node) if as_condition else self.expression(node)
        work, self.scope.block = self.scope.block, outer
        return value, work

    def plain(self, node: ast.expr) -> Value:
        """A value that takes no statements: the third of a < b < c, which may never be asked for."""
        value, work = self.apart(node, as_condition=False)
        if work:
            raise self.scope.error(f"{ast.unparse(node)!r} has no equal in C here", node, "name it before")
        return value

    def joined(self, sign: str, parts: Sequence[ast.expr]) -> Expression | Known:
        """``and`` and ``or``: a part is computed only if those before do not decide."""
        decisive = sign == "||"
        found = self.condition(parts[0])
        for part in parts[1:]:
            if isinstance(found, Known):
                found = Known(decisive) if found.value == decisive else self.condition(part)
                continue
            value, work = self.apart(part, as_condition=True)
            truth: Expression | Known = value  # type: ignore[assignment]
            found = (
                self.late(sign, found, truth, work, part)
                if work
                else self.arithmetic.joined(sign, [found, truth])
            )
        return found

    def late(
        self, sign: str, first: Expression, second: Value, work: list[Statement], node: ast.AST
    ) -> Expression:
        """Two conditions joined, the second of which takes statements that the first one guards."""
        own = self.scope.declared(self.scope.fresh("holds"), BOOL)
        self.scope.changed(own, first)
        goes_on = own if sign == "&&" else Unary(BOOL, "!", own)
        last = Assign(own.name, self.arithmetic.runtime(second, node))
        self.scope.block.append(If(goes_on, [*work, last], []))
        return own

    def chosen(self, condition: Expression, body: ast.expr, otherwise: ast.expr, node: ast.AST) -> Expression:
        """A conditional expression, of which only one side is computed."""
        (a, before_a), (b, before_b) = (self.apart(one, as_condition=False) for one in (body, otherwise))
        if not before_a and not before_b:
            return self.arithmetic.choice(condition, a, b, node)
        first, second = self.arithmetic.alike(a, b, node)
        own = self.scope.declared(self.scope.fresh("chosen"), first.type)
        ways = [*before_a, Assign(own.name, first)], [*before_b, Assign(own.name, second)]
        self.scope.certain.add(own.name)
        self.scope.block.append(If(condition, *ways))
        return own

    def call(self, node: ast.Call) -> Value:
        if any(keyword.arg is None for keyword in node.keywords):
            raise self.scope.error("arguments with ** cannot be translated to C", node, "name each of them")
        callee = self.calls.callee(self.expression(node.func), node)
        given = self.arguments(node.args)
        named = {str(one.arg): self.expression(one.value) for one in node.keywords}
        return self.calls.call(callee, given, named, node)

    def arguments(self, nodes: Sequence[ast.expr]) -> list[Value]:
        """Values in a row, those of lists that are unpacked among them."""
        values: list[Value] = []
        for node in nodes:
            values += self.unpack(node.value) if isinstance(node, ast.Starred) else [self.expression(node)]
        return values

    def unpack(self, node: ast.expr) -> list[Value]:
        """The values of a list whose length is known, such as ``[0.0] * 120``."""
        match node:
            case ast.List(elts=elements) | ast.Tuple(elts=elements):
                return self.arguments(elements)
            case ast.BinOp(left=left, op=ast.Mult(), right=right):
                count = self.expression(right)
                if isinstance(count, Known) and type(count.value) is int:
                    return self.unpack(left) * count.value
        way_out = "write *[0.0] * n with a whole number n, or each of them"
        raise self.scope.error(f"*{ast.unparse(node)} cannot be translated to C", node, way_out)

    def kept(self, value: Expression) -> Expression:
        """A record as it is now, where it may change later."""
        base = value
        while isinstance(base, Member):
            base = base.base
        if isinstance(base, Variable) and not base.mutable:
            return value
        named = self.scope.let(self.scope.fresh("record"), value)
        return named if isinstance(named, Expression) else value
