"""The functions of Python that are in the language: of numbers, and of tuples."""

import ast
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hydroservo.core.ops import basic
from hydroservo.language.arithmetic import Arithmetic, is_truth
from hydroservo.language.scope import Scope, Value
from hydroservo.language.terms import (
    BOOL,
    INT,
    REAL,
    Array,
    Bound,
    Call,
    ConstantArray,
    Conversion,
    Expression,
    HostObject,
    Known,
    Length,
    Literal,
    Record,
    Several,
    Translator,
    Type,
)

NUMBERS: dict[Type, type] = {REAL: float, INT: int, BOOL: bool}


class Builtins:
    """Python's functions on the values of one function.

    Every method raises :class:`TranslationError` for what is not in the language.
    """

    def __init__(
        self,
        translator: Translator,
        scope: Scope,
        arithmetic: Arithmetic,
        items: Callable[[Value, ast.AST], list[Value]],
    ) -> None:
        self.translator, self.scope, self.arithmetic, self.items = translator, scope, arithmetic, items
        self.functions: dict[Any, Callable[..., Value]] = {
            abs: self.absolute,
            bool: self.truth,
            enumerate: self.enumerate_values,
            float: lambda node, value: arithmetic.real(value, node),
            hasattr: self.has,
            int: self.integer,
            isinstance: self.is_instance,
            len: self.length,
            max: lambda node, *values: self.extreme(ast.Gt(), values, node),
            min: lambda node, *values: self.extreme(ast.Lt(), values, node),
            reversed: lambda node, value: as_values(items(value, node)[::-1], once=True),
            tuple: lambda node, value: as_values(items(value, node)),
            zip: self.zip_values,
        }

    def call(
        self, function: Any, given: Sequence[Value], named: Mapping[str, Value], node: ast.Call
    ) -> Value:
        """What a function of Python returns for some values."""
        try:
            return self.functions[function](node, *given, **named)
        except (ArithmeticError, TypeError, ValueError):
            problem = f"{ast.unparse(node)} is not supported with such arguments"
            raise self.scope.error(problem, node) from None

    def absolute(self, node: ast.AST, value: Value) -> Value:
        if isinstance(value, Known):
            return Known(abs(value.value))
        if self.arithmetic.whole(value):
            number = self.arithmetic.integer(value, node)
            negative = self.arithmetic.comparison(number, ast.Lt(), Known(0), node)
            assert isinstance(negative, Expression)
            return self.arithmetic.choice(
                negative, self.arithmetic.minus(number, node), number, node, both=True
            )
        function = self.translator.function(basic.absolute, [REAL])
        return Call(REAL, function, (self.arithmetic.real(value, node),), ast.unparse(node))

    def truth(self, node: ast.AST, value: Value) -> Value:
        if isinstance(value, Known):
            return Known(bool(value.value))
        if is_truth(value):
            return value
        return self.arithmetic.comparison(value, ast.NotEq(), Known(0), node)

    def integer(self, node: ast.AST, value: Value) -> Value:
        """A whole number of one, or in hydroservo's own text of a float that is known to be small."""
        if isinstance(value, Known):
            return Known(int(value.value))
        if isinstance(value, Literal):
            return Known(int(value.value))
        if self.arithmetic.whole(value):
            return self.arithmetic.integer(value, node)
        if not self.scope.house:
            raise self.scope.error("int of a float is not supported", node, "use ops.floor or ops.nearest")
        return Conversion(INT, self.arithmetic.real(value, node))

    def extreme(self, op: ast.cmpop, values: Sequence[Value], node: ast.AST) -> Value:
        """The first of some numbers than which none is smaller, or larger."""
        values = self.items(values[0], node) if len(values) == 1 else values
        best, *others = (self.scope.let(self.scope.fresh("number"), value) for value in values)
        for other in others:
            better = self.arithmetic.comparison(other, op, best, node)
            if isinstance(better, Known):
                best = other if better.value else best
            else:
                best = self.scope.let(
                    self.scope.fresh("number"), self.arithmetic.choice(better, other, best, node, both=True)
                )
        return best

    def length(self, node: ast.AST, value: Value) -> Value:
        if isinstance(value, Expression) and isinstance(value.type, Array):
            return length_of(value, value.type, 0)
        if isinstance(value, ConstantArray):
            return Known(len(value.array))
        if isinstance(value, Several) and value.once:
            raise TypeError
        return Known(len(self.items(value, node)))

    def enumerate_values(self, node: ast.AST, value: Value, start: Value | None = None) -> Value:
        pairs = enumerate(self.items(value, node), 0 if start is None else self.known_value(start))
        return as_values([as_values((Known(i), item)) for i, item in pairs], once=True)

    def zip_values(self, node: ast.AST, *rows: Value, strict: Value | None = None) -> Value:
        whole = strict is not None and bool(self.known_value(strict))
        pairs = zip(*(self.items(row, node) for row in rows), strict=whole)
        return as_values([as_values(pair) for pair in pairs], once=True)

    def known_value(self, value: Value) -> Any:
        """What is part of the code."""
        if not isinstance(value, Known):
            raise TypeError
        return value.value

    def is_instance(self, node: ast.AST, value: Value, kinds: Value) -> Known:
        several_kinds = kinds.items if isinstance(kinds, Several) else (kinds,)
        classes = tuple(one.thing for one in several_kinds if isinstance(one, HostObject))
        if isinstance(value, Known):
            return Known(isinstance(value.value, classes))
        if isinstance(value, Several):
            return Known(issubclass(tuple, classes))
        if isinstance(value, Expression):
            return Known(issubclass(class_of(value.type), classes))
        return Known(not isinstance(value, Bound) and isinstance(value.thing, classes))  # type: ignore[union-attr]

    def has(self, node: ast.AST, value: Value, name: Value) -> Known:
        """Whether a block has a field or a method of a name."""
        if isinstance(value, Expression) and isinstance(value.type, Record) and isinstance(name, HostObject):
            return Known(hasattr(value.type.cls, name.thing))
        raise self.scope.error(f"{ast.unparse(node)} is not supported", node)


def length_of(array: Expression, kind: Array, axis: int) -> Value:
    known = kind.lengths[axis]
    return Length(INT, array, axis) if known is None else Known(known)


def class_of(kind: Type) -> type:
    """The class of a value in Python."""
    if isinstance(kind, Record):
        return kind.cls or tuple
    return NUMBERS.get(kind, object)


def as_values(items: Sequence[Value], once: bool = False) -> Several:
    """Values in a row, without names of their own."""
    return Several(tuple(items), tuple(f"value_{i}" for i in range(1, len(items) + 1)), once)
