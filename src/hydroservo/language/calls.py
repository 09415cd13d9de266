"""Translates calls: of methods, of the functions of ops, and of the classes of records."""

import ast
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import FunctionType
from typing import Any

import numpy as np

from hydroservo.core.ops import basic
from hydroservo.language.arithmetic import Arithmetic
from hydroservo.language.functions import array_at
from hydroservo.language.names import snake
from hydroservo.language.ranges import LARGEST_REAL, PASSED
from hydroservo.language.scope import Scope, TranslationError, Value
from hydroservo.language.source import hint_for
from hydroservo.language.terms import (
    BOOL,
    REAL,
    Array,
    ArrayView,
    Bound,
    Call,
    Expression,
    HostObject,
    Known,
    Literal,
    Make,
    Record,
    Several,
    Translator,
    Type,
    Whole,
)

KINDS = (
    inspect.Parameter.POSITIONAL_ONLY,
    inspect.Parameter.POSITIONAL_OR_KEYWORD,
    inspect.Parameter.KEYWORD_ONLY,
)
SELECTING = (basic.clip, basic.maximum, basic.minimum)  # of ops, which return what they are given
OPEN = ("hydroservo.core.ops.", "hydroservo.core.states.", "hydroservo.core.block.", "hydroservo.engine.")
EQUALS = {  # functions that round once or never, and so give the same everywhere
    math.copysign: basic.copysign,
    math.fabs: basic.absolute,
    math.isfinite: basic.isfinite,
    math.isnan: basic.isnan,
    math.sqrt: basic.sqrt,
    np.abs: basic.absolute,
    np.copysign: basic.copysign,
    np.fabs: basic.absolute,
    np.floor: basic.floor,
    np.isfinite: basic.isfinite,
    np.isnan: basic.isnan,
    np.sqrt: basic.sqrt,
}


class Calls:
    """The calls of one function.

    Every method raises :class:`TranslationError` for what is not in the language.
    """

    def __init__(
        self, translator: Translator, scope: Scope, arithmetic: Arithmetic, constant: Callable[..., Value]
    ) -> None:
        self.translator, self.scope, self.arithmetic, self.constant = translator, scope, arithmetic, constant

    def callee(self, target: Value, node: ast.Call) -> Any:
        """What a call names, if it is in the language: a bound method, a function or a record's class."""
        if isinstance(target, Bound):
            return target
        if not isinstance(target, HostObject):
            raise self.scope.error(f"{ast.unparse(node.func)} cannot be called", node)
        thing = equal_of(target.thing)
        if not (is_record(thing) or self.is_open(thing) or (thing is array_at and self.scope.engine)):
            raise self.refusal(thing, node)
        return thing

    def is_open(self, thing: Any) -> bool:
        """True for the functions that are not methods and may be called."""
        if isinstance(thing, FunctionType):
            return f"{thing.__module__}.".startswith(OPEN) or thing in self.translator.written
        return self.scope.house and callable(thing) and thing in self.translator.written

    def call(self, callee: Any, given: Sequence[Value], named: Mapping[str, Value], node: ast.Call) -> Value:
        """A call of a callee with these positional and named arguments."""
        if isinstance(callee, Bound):
            owner = self.scope.with_address(callee.owner)
            cls = owner.type.cls if isinstance(owner.type, Record) else None
            return self.function_call(callee.function, [owner, *given], named, cls, node)
        if callee is basic.where:
            return self.where(given, node)
        if callee is array_at:
            return self.view(given, node)
        if is_record(callee):
            return self.construct(callee, given, named, node)
        return self.function_call(callee, given, named, None, node)

    def refusal(self, thing: Any, node: ast.Call) -> TranslationError:
        """What to write in place of a call that is not in the language."""
        text = ast.unparse(node)
        if hint := hint_for(thing):
            return self.scope.error(f"{text} is not supported", node, hint)
        if isinstance(thing, FunctionType):
            return self.scope.error(
                f"{text} is a function of a module", node, "make it a method of the block"
            )
        return self.scope.error(f"{text} is not supported", node)

    def view(self, given: Sequence[Value], node: ast.AST) -> ArrayView:
        """An array by its address and its lengths."""
        address, lengths = given
        assert isinstance(lengths, Several)
        known = tuple(one.value if isinstance(one, Known) else None for one in lengths.items)
        parts = tuple(self.arithmetic.integer(one, node) for one in lengths.items)
        return ArrayView(Array(known), self.arithmetic.integer(address, node), parts)

    def where(self, given: Sequence[Value], node: ast.AST) -> Value:
        """``ops.where``."""
        if len(given) != 3:
            raise self.scope.error("where takes a condition and two values", node, "give it three arguments")
        condition, a, b = given
        if isinstance(condition, Known) and isinstance(condition.value, bool):
            return a if condition.value else b
        if not (isinstance(condition, Expression) and condition.type == BOOL):
            raise self.scope.error("where's condition is a number, not a truth value", node, "compare it")
        return self.arithmetic.choice(condition, a, b, node, both=True)

    def function_call(
        self,
        function: FunctionType,
        given: Sequence[Value],
        named: Mapping[str, Value],
        owner: type | None,
        node: ast.AST,
    ) -> Expression:
        """A call of a function that is, or will be, translated."""
        values = self.bind(function, given, named, node)
        kinds: list[Type] = []
        for i, value in enumerate(values):
            if isinstance(value, (HostObject, Bound)):
                raise self.scope.error("an argument is a function or a class", node, "call it by its name")
            one = self.arithmetic.record_of(value, node) if isinstance(value, Several) else value
            if isinstance(one, Expression):
                self.scope.limit(one, PASSED, node)
            kinds.append(one.type if isinstance(one, Expression) else one)
            values[i] = one
        self.scope.line = getattr(node, "lineno", self.scope.line)
        callee = self.translator.function(function, kinds, owner)
        found = (value for value in values if isinstance(value, Expression))
        arguments = (self.with_address(value) for value in found)
        return Call(callee.returns, callee, tuple(arguments), ast.unparse(node))

    def bind(
        self, function: FunctionType, given: Sequence[Value], named: Mapping[str, Value], node: ast.AST
    ) -> list[Value]:
        """The arguments of a call in the order of the parameters, with defaults."""
        signature = signature_of(function)
        if any(parameter.kind not in KINDS for parameter in signature.parameters.values()):
            raise self.scope.error(
                f"{function.__qualname__} takes arguments with *", node, "name each of them"
            )
        try:
            found = signature.bind(*given, **named).arguments
        except TypeError as error:
            raise self.scope.error(f"{function.__qualname__}: {error}", node, "mend the call") from None
        values = []
        for name, parameter in signature.parameters.items():
            value = found[name] if name in found else self.default(parameter.default, function, name, node)
            takes_floats = parameter.annotation is float and function.__module__.startswith("hydroservo.")
            values.append(self.float_argument(function, value, node) if takes_floats else value)
        return values

    def float_argument(self, function: FunctionType, value: Value, node: ast.AST) -> Value:
        """An argument of what takes floats, and may return what it is given, but for most of ops."""
        if self.arithmetic.whole(value) and (function in SELECTING or not is_op(function)):
            called = f"ops.{function.__name__}" if is_op(function) else function.__qualname__
            problem = f"a whole number for {called}, which takes floats"
            raise self.scope.error(problem, node, "write 1.0 and not 1, and float(n) for a name")
        return self.arithmetic.real(value, node)

    def default(self, value: object, owner: Any, name: str, node: ast.AST) -> Value:
        """The default of a parameter or a field."""
        if type(value) is float or isinstance(value, np.float64):
            return Literal(REAL, float(value))
        return self.constant(value, f"{owner.__name__}.{name}", owner.__module__, node)

    def with_address(self, value: Expression) -> Expression:
        return self.scope.with_address(value) if isinstance(value.type, Record) else value

    def construct(self, cls: type, given: Sequence[Value], named: Mapping[str, Value], node: ast.AST) -> Make:
        """A record from positional and named fields."""
        names: tuple[str, ...] = getattr(cls, "_fields", ())
        if len(given) > len(names) or not set(named) <= set(names[len(given) :]):
            raise self.scope.error(f"{cls.__name__} does not take these fields", node, "give each field once")
        values: dict[str, Expression] = {}
        present = dict(zip(names, given, strict=False)) | dict(named)
        spare: Mapping[str, Any] = getattr(cls, "_field_defaults", {})
        for name in names:
            if name not in present and name not in spare:
                raise self.scope.error(f"{cls.__name__} is given no {name}", node, "give every field")
            value = present[name] if name in present else self.default(spare[name], cls, name, node)
            values[name] = self.field(value, node)
            self.scope.limit(values[name], LARGEST_REAL, node)
        kinds = {name: value.type for name, value in values.items()}
        try:
            record = self.translator.record(cls, kinds, snake(cls.__name__))
        except TranslationError as error:
            raise self.scope.error(str(error), node, "rename one of them") from None
        return Make(record, values)

    def field(self, value: Value, node: ast.AST) -> Expression:
        """What a field of a record is given; numbers and switches that the engine's text names stay known."""
        if isinstance(value, Known) and self.scope.engine:
            return Whole(value, value.value)
        return self.arithmetic.runtime(value, node)


@cache
def signature_of(function: FunctionType) -> inspect.Signature:
    return inspect.signature(function)


def equal_of(thing: Any) -> Any:
    """The function of ops that does what one of Python's does; itself where there is none."""
    try:
        return EQUALS.get(thing, thing)
    except TypeError:
        return thing


def is_record(thing: Any) -> bool:
    """True for a class of records."""
    return isinstance(thing, type) and issubclass(thing, tuple) and hasattr(thing, "_fields")


def is_op(function: Any) -> bool:
    """True for the functions of ops."""
    return f"{getattr(function, '__module__', '')}.".startswith("hydroservo.core.ops.")
