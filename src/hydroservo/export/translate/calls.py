"""Translates calls: of methods, of the functions of ops, and of the classes of records."""

import ast
import inspect
from collections.abc import Mapping, Sequence
from types import FunctionType
from typing import Any

import numpy as np

from hydroservo.engine.lower.source import hint_for
from hydroservo.export.names import snake
from hydroservo.export.translate.arithmetic import Arithmetic
from hydroservo.export.translate.ranges import LARGEST_REAL, PASSED
from hydroservo.export.translate.scope import Scope, TranslationError, Value
from hydroservo.export.translate.terms import (
    BOOL,
    REAL,
    Bound,
    Call,
    Expression,
    Known,
    Literal,
    Make,
    Matrix,
    Python,
    Record,
    Several,
    Translator,
    Type,
)
from hydroservo.ops import basic

PLAIN = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
SELECTING = (basic.clip, basic.maximum, basic.minimum)  # of ops, which return what they are given


class Calls:
    """The calls of one function.

    Every method raises :class:`TranslationError` where C has no equal.
    """

    def __init__(self, translator: Translator, scope: Scope, arithmetic: Arithmetic) -> None:
        self.translator, self.scope, self.arithmetic = translator, scope, arithmetic

    def callee(self, target: Value, node: ast.Call) -> Any:
        """What a call names, if C can call it: a bound method, a function, a record's class or float."""
        if isinstance(target, Bound):
            return target
        if not isinstance(target, Python):
            raise self.scope.error(f"{ast.unparse(node.func)} cannot be called", node)
        thing = target.thing
        written = isinstance(thing, FunctionType) and (is_op(thing) or thing in self.translator.written)
        if not (written or is_record(thing) or (thing is float and len(node.args) == 1)):
            raise self.refused(thing, node)
        return thing

    def call(self, callee: Any, given: Sequence[Value], named: Mapping[str, Value], node: ast.Call) -> Value:
        """A call of a callee with these positional and named arguments."""
        if isinstance(callee, Bound):
            owner = self.scope.lasting(callee.owner)
            cls = owner.type.cls if isinstance(owner.type, Record) else None
            return self.invoked(callee.function, [owner, *given], named, cls, node)
        if callee is basic.where:
            return self.where(given, node)
        if callee is float:
            return self.arithmetic.real(given[0], node)
        if is_record(callee):
            return self.made(callee, given, named, node)
        return self.invoked(callee, given, named, None, node)

    def refused(self, thing: Any, node: ast.Call) -> TranslationError:
        """What to write in place of a call that has no equal."""
        text = ast.unparse(node.func)
        if hint := hint_for(thing):
            return self.scope.error(f"{text} has no equal in C here", node, hint)
        if isinstance(thing, FunctionType):
            return self.scope.error(
                f"{text} is a function of a module", node, "make it a method of the block"
            )
        return self.scope.error(f"{text} has no equal in C here", node)

    def where(self, given: Sequence[Value], node: ast.AST) -> Value:
        """``ops.where``."""
        if len(given) != 3:
            raise self.scope.error("where takes a condition and two values", node, "give it three arguments")
        condition, a, b = given
        if isinstance(condition, Known) and isinstance(condition.value, bool):
            return a if condition.value else b
        if not (isinstance(condition, Expression) and condition.type == BOOL):
            raise self.scope.error("where's condition is a number, not a truth value", node, "compare it")
        return self.arithmetic.choice(condition, a, b, node)

    def invoked(
        self,
        function: FunctionType,
        given: Sequence[Value],
        named: Mapping[str, Value],
        owner: type | None,
        node: ast.AST,
    ) -> Expression:
        """A call of a function that is, or will be, in C."""
        values = self.bound(function, given, named, node)
        kinds: list[Type] = []
        for value in values:
            if isinstance(value, (Python, Bound, Several)):
                raise self.scope.error("an argument is not a value in C", node)
            if isinstance(value, Expression):
                self.scope.limit(value, PASSED, node)
            kinds.append(value.type if isinstance(value, Expression) else value)
        callee = self.translator.function(function, kinds, owner)
        found = (value for value in values if isinstance(value, Expression))
        arguments = (self.addressable(value) for value in found)
        return Call(callee.returns, callee, tuple(arguments), ast.unparse(node))

    def bound(
        self, function: FunctionType, given: Sequence[Value], named: Mapping[str, Value], node: ast.AST
    ) -> list[Value]:
        """The arguments of a call in the order of the parameters, with defaults."""
        signature = inspect.signature(function)
        if any(parameter.kind not in PLAIN for parameter in signature.parameters.values()):
            raise self.scope.error(
                f"{function.__qualname__} takes arguments with *", node, "name each of them"
            )
        try:
            found = signature.bind(*given, **named).arguments
        except TypeError as error:
            raise self.scope.error(f"{function.__qualname__}: {error}", node, "mend the call") from None
        values = []
        for name, parameter in signature.parameters.items():
            value = found[name] if name in found else self.default(parameter.default, node)
            takes_floats = parameter.annotation is float and function.__module__.startswith("hydroservo.")
            values.append(self.floating(function, value, node) if takes_floats else value)
        return values

    def floating(self, function: FunctionType, value: Value, node: ast.AST) -> Value:
        """An argument of what takes floats, and may return what it is given, but for most of ops."""
        if self.arithmetic.whole(value) and (function in SELECTING or not is_op(function)):
            called = f"ops.{function.__name__}" if is_op(function) else function.__qualname__
            problem = f"a whole number for {called}, which takes floats"
            raise self.scope.error(problem, node, "write 1.0 and not 1, and float(n) for a name")
        return self.arithmetic.real(value, node)

    def default(self, value: object, node: ast.AST) -> Value:
        """A parameter's default as a value."""
        if type(value) in (bool, int):
            return Known(value)  # type: ignore[arg-type]
        if type(value) is float or isinstance(value, np.float64):
            return Literal(REAL, float(value))
        raise self.scope.error(f"the default {value!r} is neither a number nor a truth value", node)

    def addressable(self, value: Expression) -> Expression:
        return self.scope.lasting(value) if isinstance(value.type, (Record, Matrix)) else value

    def made(self, cls: type, given: Sequence[Value], named: Mapping[str, Value], node: ast.AST) -> Make:
        """A record from positional and named fields."""
        names: tuple[str, ...] = getattr(cls, "_fields", ())
        if len(given) > len(names) or not set(named) <= set(names[len(given) :]):
            raise self.scope.error(f"{cls.__name__} does not take these fields", node, "give each field once")
        values: dict[str, Expression] = {}
        found = dict(zip(names, given, strict=False)) | dict(named)
        for name in names:
            if name not in found:
                raise self.scope.error(f"{cls.__name__} is given no {name}", node, "give every field")
            values[name] = self.arithmetic.runtime(found[name], node)
            self.scope.limit(values[name], LARGEST_REAL, node)
        kinds = {name: value.type for name, value in values.items()}
        try:
            record = self.translator.record(cls, kinds, snake(cls.__name__))
        except TranslationError as error:
            raise self.scope.error(str(error), node, "rename one of them") from None
        return Make(record, values)


def is_record(thing: Any) -> bool:
    """True for a class of records."""
    return isinstance(thing, type) and issubclass(thing, tuple) and hasattr(thing, "_fields")


def is_op(function: Any) -> bool:
    """True for the functions of ops."""
    return f"{getattr(function, '__module__', '')}.".startswith("hydroservo.ops.")
