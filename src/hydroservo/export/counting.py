"""Counts the arithmetic of translated functions, in the terms that are written as C."""

from collections.abc import Iterable, Sequence
from functools import reduce

from hydroservo.export.c.primitives import numbers
from hydroservo.export.unit import Operations
from hydroservo.language import terms
from hydroservo.language.liveness import Liveness, matters

NONE = Operations()
SIGNS = {
    "+": Operations(additions=1),
    "-": Operations(additions=1),
    "*": Operations(multiplications=1),
    "/": Operations(divisions=1),
    **{sign: Operations(comparisons=1) for sign in ("<", "<=", ">", ">=", "==", "!=")},
}
WRITTEN = {
    numbers.ABSOLUTE: NONE,
    numbers.COPYSIGN: NONE,
    numbers.FMOD: Operations(functions=1),
    numbers.MODULO: NONE,
    numbers.QUOTIENT: NONE,
    numbers.FLOOR: Operations(additions=3, comparisons=2),
    numbers.ISFINITE: Operations(comparisons=1),
    numbers.ISNAN: Operations(comparisons=1),
    numbers.SQRT: Operations(roots=1, comparisons=1),
    numbers.EXPONENT: NONE,
    numbers.MANTISSA: NONE,
    numbers.SCALED_NUMBER: Operations(additions=1, multiplications=2),
}
FUNCTIONS = {f"hydroservo.core.ops.{name}" for name in ("circular", "hyperbolic", "power")}


class UncountedError(Exception):
    """There is no most: a loop goes on as long as its numbers ask, or a text in C is not known here."""


def operation_count(function: terms.Function, needed: Liveness) -> Operations | None:
    """What a call of a function takes at most; None where there is no most."""
    try:
        return Count(needed).function(function)
    except UncountedError:
        return None


class Count:
    """The operations of functions, each counted once.

    Every method raises :class:`UncountedError` where there is no most.
    """

    def __init__(self, needed: Liveness) -> None:
        self.needed = needed
        self.found: dict[terms.Function, Operations] = {}

    def function(self, function: terms.Function) -> Operations:
        """A call, without what its arguments take."""
        if function not in self.found:
            count = (
                self.body(function.body, self.needed.locals[function])
                if function.body
                else self.text(function)
            )
            is_one = getattr(function.origin, "__module__", "") in FUNCTIONS
            self.found[function] = count._replace(functions=1) if is_one else count
        return self.found[function]

    def text(self, function: terms.Function) -> Operations:
        """A function that is written, not translated."""
        if function not in WRITTEN:
            raise UncountedError
        return WRITTEN[function]

    def body(self, statements: Sequence[terms.Statement], names: set[str]) -> Operations:
        """Statements that are written, which give values to these names."""
        return total_operations(self.statement(one, names) for one in statements if matters(one, names))

    def statement(self, one: terms.Statement, names: set[str]) -> Operations:
        match one:
            case terms.Let(value=value) | terms.Assign(value=value) | terms.Return(value=value):
                return self.value(value)
            case terms.If(condition=condition, body=body, otherwise=otherwise):
                ways = [self.body(way, names) for way in (body, otherwise)]
                return self.value(condition).plus(dearer_way(*ways))
            case terms.For(body=body) if (turns := one.turns()) is not None:
                return self.body(body, names).times(turns)
            case terms.For() | terms.While():
                raise UncountedError
        return NONE

    def value(self, value: terms.Expression) -> Operations:
        """What it takes to compute a value."""
        if not self.needed.kept(value.type):
            return NONE
        if isinstance(value, terms.Choice):
            return self.value(value.condition).plus(dearer_way(self.value(value.a), self.value(value.b)))
        return total_operations([self.last(value), *map(self.value, self.before(value))])

    def last(self, value: terms.Expression) -> Operations:
        """What it takes where all that it is made of is there."""
        match value:
            case terms.Operation(operator=sign, a=a) if a.type == terms.REAL:
                return SIGNS[sign]
            case terms.Call(function=function):
                return self.function(function)
        return NONE

    def before(self, value: terms.Expression) -> list[terms.Expression]:
        """What it is made of, as far as it is written."""
        match value:
            case terms.Call(function=function, arguments=arguments):
                taken = {name for name, _ in self.needed.takes(function)}
                pairs = zip(function.parameters, arguments, strict=True)
                return [one for (name, _), one in pairs if name in taken]
            case terms.Make(type=terms.Record() as record, values=values):
                return [one for name, one in values.items() if self.needed.has(record, name)]
        return list(terms.operands(value))


def total_operations(counts: Iterable[Operations]) -> Operations:
    return reduce(Operations.plus, counts, NONE)


def dearer_way(a: Operations, b: Operations) -> Operations:
    """Of two ways the one that takes more."""
    return a if a.total >= b.total else b
