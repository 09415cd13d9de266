"""Translates expressions of Python."""

import ast
import builtins
import math
from collections.abc import Callable, Sequence
from functools import partial
from numbers import Number
from types import ModuleType
from typing import Any

import numpy as np

from hydroservo.core.block import is_block
from hydroservo.language.arithmetic import Arithmetic, is_truth
from hydroservo.language.bindings import Binding
from hydroservo.language.builtin import Builtins, as_values, length_of
from hydroservo.language.calls import Calls
from hydroservo.language.scope import Scope, Value, known_value
from hydroservo.language.source import DoubtError, own_method
from hydroservo.language.terms import (
    BOOL,
    INT,
    REAL,
    Array,
    Assign,
    Bound,
    ConstantArray,
    Element,
    Expression,
    HostObject,
    If,
    Known,
    Literal,
    Member,
    Memory,
    MemoryLoad,
    NamedNumber,
    Operation,
    Record,
    Require,
    Several,
    Statement,
    Translator,
    Unary,
    Variable,
)


class Expressions:
    """The expressions of one function.

    Every method raises :class:`TranslationError` for what is not in the language.
    """

    def __init__(self, translator: Translator, scope: Scope) -> None:
        self.scope, self.arithmetic = scope, Arithmetic(translator, scope)
        self.calls = Calls(translator, scope, self.arithmetic, self.python)
        self.builtins = Builtins(translator, scope, self.arithmetic, self.items)

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
                return self.binary(op, self.expression(left), self.expression(right), node)
            case ast.UnaryOp(op=op, operand=operand):
                return self.unary(op, operand, node)
            case ast.Compare() | ast.BoolOp():
                return self.condition(node, numbers=False)
            case ast.IfExp(test=test, body=body, orelse=otherwise):
                condition = self.condition(test)
                if isinstance(condition, Known):
                    return self.expression(body if condition.value else otherwise)
                return self.choice(condition, body, otherwise, node)
            case ast.Subscript(value=value, slice=index):
                return self.element(self.expression(value), index, node)
            case ast.Tuple(elts=elements):
                return as_values(self.arguments(elements))
        raise self.scope.error(f"{ast.unparse(node)!r} is not supported", node)

    def binary(self, op: ast.operator, a: Value, b: Value, node: ast.AST) -> Value:
        """a op b, of tuples one behind the other."""
        if isinstance(a, Several) and isinstance(b, Several) and isinstance(op, ast.Add):
            return as_values([*a.items, *b.items])
        return self.arithmetic.binary(op, a, b, node)

    def items(self, value: Value, node: ast.AST) -> list[Value]:
        """The values of a tuple or a record."""
        if isinstance(value, Several):
            return list(value.items)
        if isinstance(value, Expression) and isinstance(value.type, Record):
            lasting = self.scope.with_address(value)
            return [self.member(lasting, name) for name in value.type.fields]
        raise self.scope.error("this is not several values", node)

    def constant(self, value: object, node: ast.AST) -> Value:
        if isinstance(value, (bool, int)) or value is None:
            return Known(value)
        if isinstance(value, float):
            return Literal(REAL, value)
        special = value in ("nan", "inf", "-inf")
        if isinstance(value, str) and not special:
            return HostObject(value)
        way_out = "use math.nan or math.inf" if special else "use numbers"
        raise self.scope.error(f"{value!r} is neither a number nor a truth value", node, way_out)

    def named(self, name: str, node: ast.AST) -> Value:
        """What a name stands for where a node reads it."""
        binding = self.scope.bindings.variable_read(node)
        if binding is not None and binding in self.scope.environment:
            return self.local(binding, node)
        if name in self.scope.bindings.bound:
            raise self.scope.error(f"{name} may have no value yet", node, "give it one on every path")
        if name.startswith("__"):
            raise self.scope.error(f"{name} is a name that Python changes", node, "take another one")
        if name in self.scope.outside:
            return self.python(self.scope.outside[name], name, self.scope.origin.__module__, node)
        namespace = self.scope.origin.__globals__
        if name in namespace:
            return self.python(namespace[name], name, self.scope.origin.__module__, node)
        if hasattr(builtins, name):
            return HostObject(getattr(builtins, name))
        raise self.scope.error(f"{name} is not defined", node)

    def local(self, binding: Binding, node: ast.AST) -> Value:
        value = self.scope.environment[binding]
        if isinstance(value, Variable) and value.mutable and value.name not in self.scope.certain:
            problem = f"{binding.name} may have no value yet"
            raise self.scope.error(problem, node, "give it one on every path")
        return value

    def python(self, thing: Any, name: str, module: str, node: ast.AST) -> Value:
        """Something that a module holds."""
        if type(thing) in (bool, int) or thing is None:
            return Known(thing)
        if type(thing) is tuple:
            return as_values(
                [self.python(one, f"{name}_{i}", module, node) for i, one in enumerate(thing, 1)]
            )
        if type(thing) is float or isinstance(thing, np.float64):  # whose arithmetic is that of floats
            number = float(thing)
            special = not math.isfinite(number)
            return Literal(REAL, number) if special else NamedNumber(REAL, module, name, number)
        if isinstance(thing, Number):
            problem = f"{name} is a {type(thing).__name__}, whose arithmetic is not that of floats"
            raise self.scope.error(problem, node, f"write {name} = float(...)")
        if is_block(thing):
            parts = [
                self.block_field(thing, field, f"{name}.{field}", module, node) for field in thing._fields
            ]
            return self.calls.construct(type(thing), parts, {}, node)
        if callable(thing) or isinstance(thing, ModuleType):
            return HostObject(thing)
        raise self.scope.error(
            f"{name} is a {type(thing).__name__}, which a law cannot use", node, "use floats and blocks"
        )

    def block_field(self, block: Any, field: str, name: str, module: str, node: ast.AST) -> Value:
        value = getattr(block, field)
        return Literal(REAL, value) if type(value) is float else self.python(value, name, module, node)

    def attribute(self, base: Value, name: str, node: ast.AST) -> Value:
        if isinstance(base, HostObject):
            if not isinstance(base.thing, ModuleType) or not hasattr(base.thing, name):
                raise self.scope.error(f"{ast.unparse(node)} is not there", node)
            return self.python(getattr(base.thing, name), name, base.thing.__name__, node)
        if isinstance(base, ConstantArray) and name in ("size", "ndim"):
            return Known(getattr(base.array, name))
        if isinstance(base, ConstantArray) and name == "shape":
            return as_values([Known(length) for length in base.array.shape])
        if isinstance(base, Expression) and isinstance(base.type, Array):
            return self.of_array(base, base.type, name, node)
        if isinstance(base, Expression) and isinstance(base.type, Record):
            if name in base.type.fields:
                return self.member(self.scope.with_address(base), name)
            return self.method(base, base.type, name, node)
        raise self.scope.error(f"{ast.unparse(node)!r} is not there", node)

    def of_array(self, base: Expression, kind: Array, name: str, node: ast.AST) -> Value:
        """What an array says of itself."""
        lengths = [length_of(base, kind, axis) for axis in range(len(kind.lengths))]
        if name == "shape":
            return as_values(lengths)
        if name == "ndim":
            return Known(len(lengths))
        if name != "size":
            raise self.scope.error(f"{ast.unparse(node)!r} is not there", node)
        total: Value = Known(1)
        for length in lengths:
            total = self.arithmetic.binary(ast.Mult(), total, length, node)
        return total

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
        return known_value(kind) if isinstance(kind, (Known, ConstantArray)) else Member(kind, base, name)

    def element(self, owner: Value, index: ast.expr, node: ast.AST) -> Value:
        if isinstance(owner, Several) or (isinstance(owner, Expression) and isinstance(owner.type, Record)):
            return self.entry(owner, index, node)
        if isinstance(owner, Expression) and isinstance(owner.type, Memory):
            return MemoryLoad(owner.type.element, owner, self.index(index, node))
        if isinstance(owner, Expression) and isinstance(owner.type, Array):
            lengths = [length_of(owner, owner.type, axis) for axis in range(len(owner.type.lengths))]
            return MemoryLoad(REAL, owner, self.flat_index(index, lengths, node))
        if not isinstance(owner, ConstantArray):
            raise self.scope.error("only tuples, vectors and arrays of recorded signals can be indexed", node)
        return Element(
            REAL, owner, self.flat_index(index, [Known(length) for length in owner.array.shape], node)
        )

    def flat_index(self, index: ast.expr, lengths: Sequence[Value], node: ast.AST) -> Value:
        """Where the number at some indices stands in an array, row by row."""
        parts = index.elts if isinstance(index, ast.Tuple) else [index]
        if len(parts) != len(lengths):
            raise self.scope.error(f"this array takes {len(lengths)} indices", node)
        total: Value = Known(0)
        for part, length in zip(parts, lengths, strict=True):
            within = self.within(self.expression(part), length, node)
            total = within if total == Known(0) else self.index_after(total, length, within, node)
        return total

    def index_after(self, total: Value, length: Value, within: Value, node: ast.AST) -> Value:
        """total length + within."""
        if isinstance(length, Known):
            scaled = self.arithmetic.binary(ast.Mult(), total, length, node)
            return self.arithmetic.binary(ast.Add(), scaled, within, node)
        first, second, last = (self.arithmetic.integer(one, node) for one in (total, length, within))
        return Operation(INT, "+", Operation(INT, "*", first, second), last)

    def index(self, node: ast.expr, owner: ast.AST) -> Value:
        """A whole number that counts from the front."""
        found = self.expression(node)
        if not self.arithmetic.whole(found):
            raise self.scope.error("an index must be a whole number", owner)
        return found

    def within(self, index: Value, length: Value, node: ast.AST) -> Value:
        """An index counted from the front, of which it is sure that it is within an array.

        Of one that is found at run time, the numbers are looked at while it is translated where the length is
        known by then, and each time it is used where not; the house's own searches stay within.
        """
        if not self.arithmetic.whole(index):
            raise self.scope.error("an index must be a whole number", node)
        index = self.arithmetic.counting(index, node)
        if isinstance(index, Known) and isinstance(length, Known):
            if not -length.value <= index.value < length.value:
                raise self.scope.error(f"the index {index.value} is out of the array's {length.value}", node)
            return Known(index.value % length.value)
        if isinstance(length, Known):
            assert isinstance(index, Expression)
            self.scope.limit(index, length.value - 1, node, least=0)
            return index
        if isinstance(index, Known) and index.value < 0:
            index = self.arithmetic.binary(ast.Add(), length, index, node)
        held = self.scope.let(self.scope.fresh("index"), index)
        compare = self.arithmetic.comparison
        ends = [compare(Known(0), ast.LtE(), held, node), compare(held, ast.Lt(), length, node)]
        condition = self.arithmetic.logic("&", ends)
        assert isinstance(condition, Expression)
        self.scope.block.append(Require(condition))
        return held

    def entry(self, owner: Value, index: ast.expr, node: ast.AST) -> Value:
        """A value of a tuple or a record by its number, or some of them."""
        items = self.items(owner, node)
        if isinstance(index, ast.Slice):
            ends = [
                Known(None) if one is None else self.expression(one)
                for one in (index.lower, index.upper, index.step)
            ]
            if all(isinstance(one, Known) for one in ends) and ends[2] != Known(0):
                return as_values(items[slice(*(one.value for one in ends if isinstance(one, Known)))])
        number = self.expression(index) if not isinstance(index, ast.Slice) else Known(None)
        if not (isinstance(number, Known) and isinstance(number.value, int)):
            raise self.scope.error("an entry is found by a known number alone", node)
        if not -len(items) <= number.value < len(items):
            raise self.scope.error(f"the index {number.value} is out of the record's {len(items)}", node)
        return items[number.value]

    def unary(self, op: ast.unaryop, operand: ast.expr, node: ast.AST) -> Value:
        if isinstance(op, ast.Not):
            return self.arithmetic.negation(self.condition(operand))
        if isinstance(op, ast.USub):
            return self.arithmetic.minus(self.expression(operand), node)
        if isinstance(op, ast.UAdd):
            value = self.expression(operand)
            return self.arithmetic.integer(value, node) if is_truth(value) else value
        raise self.scope.error("this operation is not supported", node)

    def condition(self, node: ast.expr, numbers: bool = True) -> Expression | Known:
        """A truth value; ``numbers`` count as true unless they are 0."""
        match node:
            case ast.Compare(left=left, ops=operators, comparators=[right, *rest]):
                values = [self.expression(left), self.expression(right), *map(self.pure, rest)]
                pairs = zip(values, operators, values[1:], strict=False)
                return self.arithmetic.logic("&&", [self.comparison(*one, node) for one in pairs])
            case ast.BoolOp(op=op, values=parts):
                return self.logic("&&" if isinstance(op, ast.And) else "||", parts, numbers)
        value = self.expression(node)
        if is_truth(value):
            return value  # type: ignore[return-value]
        if isinstance(value, Known) and numbers:
            return Known(bool(value.value))
        if isinstance(value, Expression) and value.type in (REAL, INT) and numbers:
            return self.arithmetic.comparison(value, ast.NotEq(), Known(0), node)
        raise self.scope.error(f"{ast.unparse(node)!r} is not a truth value", node, "compare it")

    def comparison(self, a: Value, op: ast.cmpop, b: Value, node: ast.AST) -> Expression | Known:
        """a < b and its like, or whether a is among others."""
        if not isinstance(op, (ast.In, ast.NotIn)):
            return self.arithmetic.comparison(a, op, b, node)
        each = [self.arithmetic.comparison(a, ast.Eq(), item, node) for item in self.items(b, node)]
        among = self.arithmetic.logic("||", each)
        return self.arithmetic.negation(among) if isinstance(op, ast.NotIn) else among

    # what is computed only if something else holds

    def split(self, node: ast.expr, value_of: Callable[[ast.expr], Value]) -> tuple[Value, list[Statement]]:
        """A value, and the statements that must run before it."""
        outer, self.scope.block = self.scope.block, []
        value = value_of(node)
        work, self.scope.block = self.scope.block, outer
        return value, work

    def pure(self, node: ast.expr) -> Value:
        """A value that takes no statements: the third of a < b < c, which may never be asked for."""
        value, work = self.split(node, self.expression)
        if work:
            raise self.scope.error(f"{ast.unparse(node)!r} is not supported", node, "name it before")
        return value

    def logic(self, sign: str, parts: Sequence[ast.expr], numbers: bool) -> Expression | Known:
        """``and`` and ``or``: a part is computed only if those before do not decide."""
        decisive, truth_of = sign == "||", partial(self.condition, numbers=numbers)
        found = truth_of(parts[0])
        for part in parts[1:]:
            if isinstance(found, Known):
                found = Known(decisive) if found.value == decisive else truth_of(part)
                continue
            value, work = self.split(part, truth_of)
            truth: Expression | Known = value  # type: ignore[assignment]
            found = (
                self.guard(sign, found, truth, work, part)
                if work
                else self.arithmetic.logic(sign, [found, truth])
            )
        return found

    def guard(
        self, sign: str, first: Expression, second: Value, work: list[Statement], node: ast.AST
    ) -> Expression:
        """Two conditions joined, the second of which takes statements that the first one guards."""
        own = self.scope.declare(self.scope.fresh("holds"), BOOL)
        self.scope.assign(own, first)
        goes_on = own if sign == "&&" else Unary(BOOL, "!", own)
        last = Assign(own.name, self.arithmetic.runtime(second, node))
        self.scope.block.append(If(goes_on, [*work, last], []))
        return own

    def choice(self, condition: Expression, body: ast.expr, otherwise: ast.expr, node: ast.AST) -> Expression:
        """A conditional expression, of which only one side is computed."""
        (a, before_a), (b, before_b) = (self.split(one, self.expression) for one in (body, otherwise))
        if not before_a and not before_b:
            return self.arithmetic.choice(condition, a, b, node)
        first, second = self.arithmetic.of_one_type(a, b, node)
        own = self.scope.declare(self.scope.fresh("chosen"), first.type)
        ways = [*before_a, Assign(own.name, first)], [*before_b, Assign(own.name, second)]
        self.scope.certain.add(own.name)
        self.scope.block.append(If(condition, *ways))
        return own

    def call(self, node: ast.Call) -> Value:
        if any(keyword.arg is None for keyword in node.keywords):
            raise self.scope.error("arguments with ** are not supported", node, "name each of them")
        target = self.expression(node.func)
        named = {str(one.arg): self.expression(one.value) for one in node.keywords}
        if isinstance(target, HostObject) and self.is_builtin(target.thing):
            return self.builtins.call(target.thing, self.arguments(node.args), named, node)
        callee = self.calls.callee(target, node)
        given = self.arguments(node.args)
        return self.calls.call(callee, given, named, node)

    def is_builtin(self, thing: Any) -> bool:
        """True for a function of Python that is in the language."""
        try:
            return thing in self.builtins.functions
        except TypeError:
            return False

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
            case ast.List() | ast.ListComp() | ast.BinOp():
                pass
            case _:
                return self.items(self.expression(node), node)
        way_out = "write *[0.0] * n with a whole number n, or each of them"
        raise self.scope.error(f"*{ast.unparse(node)} is not supported", node, way_out)

    def snapshot(self, value: Expression) -> Expression:
        """A record as it is now, where it may change later."""
        base = value
        while isinstance(base, Member):
            base = base.base
        if isinstance(base, Variable) and not base.mutable:
            return value
        named = self.scope.let(self.scope.fresh("record"), value)
        return named if isinstance(named, Expression) else value
