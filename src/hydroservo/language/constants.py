"""What is the same at every sample is computed once, when it is exported.

A C compiler computes with literals, and with parameters that stand in the source, but does not follow a power
or a sine through its steps. So a call of such a function of ``ops`` becomes a number where its arguments are
known.
"""

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any

from hydroservo.language import terms
from hydroservo.language.calls import is_op

LEAST, MOST = 1e-30, 1e30  # of a number's size; single precision holds what is between
OPERATORS: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
    "&&": operator.and_,
    "&": operator.and_,
    "||": operator.or_,
    "|": operator.or_,
}
UNARIES: dict[str, Callable[..., Any]] = {"-": operator.neg, "!": operator.not_}


class Varies:
    """Stands for a value that may differ from sample to sample, or that is not followed."""


VARIES = Varies()


def fold_constants(given: Mapping[terms.Function, Sequence[Any]]) -> None:
    """Puts numbers in place of calls that give the same one at every sample.

    Args:
        given: the functions that are called from outside, and what is known of their first arguments.
    """
    values = KnownValues(given)
    for function in values.reached:
        if function.owner:  # what ops compute inside depends on the format of numbers
            values.rewrite(function.body, function.name)


class KnownValues:
    """What is known of the values in some functions and in all that they call."""

    def __init__(self, given: Mapping[terms.Function, Sequence[Any]]) -> None:
        self.arguments: dict[tuple[terms.Function, str], Any] = {}
        self.calls: dict[terms.Call, Any] = {}
        self.reached: dict[terms.Function, None] = {}  # in the order of the calls
        before = -1
        while before != self.varying():  # each round knows less; what varies only grows
            before = self.varying()
            self.reached.clear()
            for function, values in given.items():
                self.visit(function, [*values, *[VARIES] * (len(function.parameters) - len(values))])

    def varying(self) -> int:
        """A number that grows with each argument that is new, or that is found to vary."""
        return len(self.arguments) + sum(value is VARIES for value in self.arguments.values())

    def visit(self, function: terms.Function, values: Sequence[Any]) -> None:
        """What is known of a function that is called with these values."""
        for (name, _), value in zip(function.parameters, values, strict=True):
            before = self.arguments.setdefault((function, name), value)
            if not same_bits(before, value):
                self.arguments[function, name] = VARIES
        if function in self.reached:
            return
        self.reached[function] = None
        for callee in function.calls:  # from text that is written in C, not translated
            self.visit(callee, [VARIES] * len(callee.parameters))
        self.follow(function.body, {name: self.arguments[function, name] for name, _ in function.parameters})

    def follow(self, body: Sequence[terms.Statement], names: dict[str, Any]) -> None:
        """What statements give their names, from what is known of those before."""
        for one in body:
            value = self.value(value_in(one), names)
            if isinstance(one, terms.Let):
                names[one.name] = value
            for inner in terms.bodies(one):
                self.follow(inner, names)

    def value(self, one: Any, names: Mapping[str, Any]) -> Any:
        """A value, or that it varies; the calls in it are visited."""
        if one is None:
            return VARIES
        parts = [self.value(part, names) for part in terms.operands(one)]
        value: Any = VARIES
        match one:
            case terms.Call(function=function):
                self.visit(function, parts)
                value = self.calls[one] = number_in_python(function, parts)
            case terms.Literal(value=number) | terms.NamedNumber(value=number) | terms.Whole(value=number):
                value = number
            case terms.Variable(name=name, mutable=False):
                value = names.get(name, VARIES)
            case terms.Make(type=terms.Record(cls=cls), values=members) if cls is not None:
                value = call_value(partial(made_record, cls, tuple(members)), parts)
            case terms.Member(name=name):
                value = call_value(getattr, [*parts, name])
            case terms.Unary(operator=sign):
                value = call_value(UNARIES[sign], parts)
            case terms.Operation(operator=sign):
                value = call_value(OPERATORS[sign], parts)
            case terms.Choice():
                value = call_value(lambda condition, a, b: a if condition else b, parts)
            case terms.Conversion():
                value = call_value(float, parts)
        return value

    def rewrite(self, body: Sequence[terms.Statement], function: str) -> None:
        """The statements with numbers in place of calls that are known."""
        for one in body:
            match one:
                case terms.Let(name=name, value=terms.Call() as value) if self.useful(value):
                    one.value = self.number(value, f"{function}_{name}")
                case terms.Let(value=value) | terms.Assign(value=value) | terms.Return(value=value):
                    one.value = self.with_numbers(value, function)
                case terms.If(condition=condition) | terms.While(condition=condition):
                    one.condition = self.with_numbers(condition, function)
            for inner in terms.bodies(one):
                self.rewrite(inner, function)

    def with_numbers(self, one: Any, function: str) -> Any:
        """An expression with numbers in place of calls that are known."""
        if isinstance(one, terms.Call) and self.useful(one):
            return self.number(one, f"{function}_{one.function.origin.__name__}")
        changes: dict[str, Any] = {}
        for field in fields(one):
            part = getattr(one, field.name)
            if isinstance(part, terms.Expression):
                changes[field.name] = self.with_numbers(part, function)
            elif isinstance(part, dict):
                changes[field.name] = {key: self.with_numbers(each, function) for key, each in part.items()}
            elif isinstance(part, tuple):
                changes[field.name] = tuple(self.with_numbers(each, function) for each in part)
        return replace(one, **changes) if changes else one

    def useful(self, call: terms.Call) -> bool:
        """True for a call that asks ops, and gives a known number, which both precisions have."""
        value = self.calls[call]
        fits = isinstance(value, float) and (value == 0.0 or LEAST < abs(value) < MOST)
        return fits and asks_ops(call.function)

    def number(self, call: terms.Call, name: str) -> terms.Computed:
        return terms.Computed(terms.REAL, name, self.calls[call], call.text)


def value_in(statement: terms.Statement) -> Any:
    """The value in a statement; None where it has none."""
    match statement:
        case terms.Let(value=value) | terms.Assign(value=value) | terms.Return(value=value):
            return value
        case terms.If(condition=condition) | terms.While(condition=condition):
            return condition
        case terms.For(stop=stop):
            return stop


def made_record(cls: type, names: Sequence[str], *values: Any) -> Any:
    return cls(**dict(zip(names, values, strict=True)))


def asks_ops(function: terms.Function) -> bool:
    """True for a translated function of ops, and for one that calls such a one."""
    return bool(function.body) and (is_op(function.origin) or any(map(asks_ops, callees(function.body))))


def callees(body: Sequence[terms.Statement]) -> Iterator[terms.Function]:
    for one in body:
        yield from callees_in(value_in(one))
        for inner in terms.bodies(one):
            yield from callees(inner)


def callees_in(one: Any) -> Iterator[terms.Function]:
    """The functions that an expression calls."""
    if isinstance(one, terms.Call):
        yield one.function
    for part in terms.operands(one):
        yield from callees_in(part)


def number_in_python(function: terms.Function, values: Sequence[Any]) -> Any:
    """What a function gives in Python, where that is a number and C is given each of its arguments."""
    origin = function.origin
    if function.returns != terms.REAL or origin is None:
        return VARIES
    code = getattr(origin, "__code__", None)
    if code is not None and code.co_argcount != len(values):
        return VARIES
    return call_value(origin, values)


def call_value(function: Any, values: Sequence[Any]) -> Any:
    """What a function gives; it varies where one of its arguments does, or Python has no number for it."""
    if any(value is VARIES for value in values):
        return VARIES
    try:
        return function(*values)
    except (ArithmeticError, TypeError, ValueError):
        return VARIES


def same_bits(a: Any, b: Any) -> bool:
    """True for one value, to the last bit."""
    if isinstance(a, tuple) and type(a) is type(b):
        return all(map(same_bits, a, b))
    return a is b or (type(a) is type(b) is float and a.hex() == b.hex())
