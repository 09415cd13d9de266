"""How large whole numbers become: what may leave the 64 bits that they have in C is refused.

Whole numbers live within one step, as states are made of floats. What is computed from counters and constants
has an interval. A local that changes has a bound instead: with M the largest of the locals that change each
other, an assignment to one of them leaves at most c M + e, and so T assignments at most c^T (M + T e).
"""

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

from hydroservo.language.functions import whole_modulo, whole_quotient
from hydroservo.language.terms import (
    INT,
    Assign,
    Call,
    Choice,
    Expression,
    For,
    Function,
    If,
    Known,
    Length,
    Let,
    Operation,
    Statement,
    Unary,
    Variable,
    While,
    Whole,
)

LARGEST = 2**63 - 1
LARGEST_REAL = 2**53  # up to here a float holds every whole number; results and fields stay within
PASSED = 2**40  # what arguments stay within
LONGEST = 2**24  # of an axis of an array
TURNS = 2**40  # no step does anything as often: it would take an hour
ENDLESS = 2**256  # stands for what has no bound

Interval = tuple[int, int]


class Growth(NamedTuple):
    """A number that is at most ``factor`` M + ``more``."""

    factor: Fraction
    more: Fraction


class Assigned(NamedTuple):
    """A value of a local that changes, and the counts of the loops around; None is a while."""

    value: Expression
    loops: tuple[For | None, ...]


class Ranges:
    """The ranges of a function's whole numbers."""

    def __init__(self, function: Function) -> None:
        self.parameters = {name for name, kind in function.parameters if kind == INT}
        self.values: dict[str, Expression] = {}
        self.counts: dict[str, list[For]] = {}
        self.assigned: dict[str, list[Assigned]] = {}
        self.bounds: dict[str, int] = {}
        self.pending: set[str] = set()
        self.gather(function.body, ())

    def gather(self, body: Sequence[Statement], loops: tuple[For | None, ...]) -> None:
        for one in body:
            match one:
                case Let(name=name, value=value) if value.type == INT:
                    self.values[name] = value
                case Assign(name=name, value=value) if value.type == INT:
                    self.assigned.setdefault(name, []).append(Assigned(value, loops))
                case If(body=inner, otherwise=otherwise):
                    self.gather(inner, loops)
                    self.gather(otherwise, loops)
                case While(body=inner):
                    self.gather(inner, (*loops, None))
                case For(name=name, body=inner):
                    self.counts.setdefault(name, []).append(one)
                    self.gather(inner, (*loops, one))

    def interval(self, value: Expression | Known) -> Interval:
        """The least and the largest number that a value may be."""
        if isinstance(value, Known | Whole):
            return int(value.value), int(value.value)
        found = -LARGEST_REAL, LARGEST_REAL  # of fields, and of what other functions return
        match value:
            case Variable(name=name):
                found = self.of_local(name)
            case Length():
                found = 0, LONGEST
            case Unary(a=a):
                found = result_interval("-", (0, 0), self.interval(a))
            case Operation(operator=sign, a=a, b=b):
                found = result_interval(sign, self.interval(a), self.interval(b))
            case Choice(a=a, b=b):
                found = hull([self.interval(a), self.interval(b)])
            case Call(function=function, arguments=(a, Whole(value=by))) if function.origin is whole_quotient:
                found = self.interval(a)[0] // by, self.interval(a)[1] // by
            case Call(function=function, arguments=(_, Whole(value=by))) if function.origin is whole_modulo:
                found = 0, by - 1
        return found

    def of_local(self, name: str) -> Interval:
        if name in self.values:
            return self.interval(self.values[name])
        if name in self.counts:
            return hull([self.of_counter(one) for one in self.counts[name]])
        if name in self.parameters:
            return -PASSED, PASSED
        bound = self.bound(name)
        return -bound, bound

    def of_counter(self, loop: For) -> Interval:
        """The interval of a loop's number while its statements run."""
        start, stop, step = map(self.interval, (loop.start, loop.stop, loop.step))
        if step[0] > 0:
            return start[0], max(start[0], stop[1] - 1)
        return min(start[1], stop[0] + 1), start[1]

    # locals that change

    def bound(self, name: str) -> int:
        """The largest that a local may become, whatever its sign."""
        if name in self.pending:
            return ENDLESS  # as the count of a loop that changes what it counts
        if name not in self.bounds:
            group = {other for other in self.reachable(name) if name in self.reachable(other)} | {name}
            self.pending |= group
            found = self.group_bound(group)
            self.pending -= group
            self.bounds |= dict.fromkeys(group, found)
        return self.bounds[name]

    def group_bound(self, group: set[str]) -> int:
        """The largest that any of some locals that change each other may become."""
        first, more, factor, turns = Fraction(0), Fraction(0), Fraction(1), 0
        for one in (one for name in group for one in self.assigned[name]):
            growth = self.growth(one.value, group)
            if growth.factor == 0:
                first = max(first, growth.more)
            else:
                factor, more = max(factor, growth.factor), max(more, growth.more)
                turns = min(TURNS, turns + self.turns(one.loops, group))
        if factor > 1 and turns > 64:
            return ENDLESS
        return min(ENDLESS, math.ceil(factor**turns * (first + turns * more))) if turns else math.ceil(first)

    def turns(self, loops: Sequence[For | None], group: set[str]) -> int:
        """How often a statement in some loops is run at most."""
        total = 1
        for loop in loops:
            ends = () if loop is None else (loop.start, loop.stop)
            known = ends and not any(isinstance(one, Expression) and self.depends(one, group) for one in ends)
            total *= self.turns_of(loop) if known and loop is not None else TURNS
        return min(TURNS, total)

    def turns_of(self, loop: For) -> int:
        """How many turns a loop takes at most."""
        start, stop, step = map(self.interval, (loop.start, loop.stop, loop.step))
        way = stop[1] - start[0] if step[0] > 0 else start[1] - stop[0]
        return max(0, -(-way // min(map(abs, step))))

    def growth(self, value: Expression | Known, group: set[str]) -> Growth:
        """What a value is at most, of the largest in a group."""
        if isinstance(value, Known) or not self.depends(value, group):
            return Growth(Fraction(0), Fraction(max(map(abs, self.interval(value)))))
        found = Growth(Fraction(ENDLESS), Fraction(ENDLESS))
        match value:
            case Variable(name=name) if name in self.values:
                found = self.growth(self.values[name], group)
            case Variable(name=name) if name in self.counts:
                found = largest_whole(
                    [self.growth(end, group) for one in self.counts[name] for end in (one.start, one.stop)]
                )
            case Variable():
                found = Growth(Fraction(1), Fraction(0))
            case Unary(a=a):
                found = self.growth(a, group)
            case Operation(operator=sign, a=a, b=b):
                found = growth_of(sign, self.growth(a, group), self.growth(b, group))
            case Choice(a=a, b=b):
                found = largest_whole([self.growth(a, group), self.growth(b, group)])
            case Call(function=function, arguments=(a, Whole(value=by))) if function.origin is whole_quotient:
                inner = self.growth(a, group)
                found = Growth(inner.factor / by, inner.more / by + 1)
        return found

    def depends(self, value: Expression, group: set[str]) -> bool:
        return bool(group & self.locals_in(value, set()))

    def reachable(self, name: str) -> set[str]:
        """The locals that a local that changes is computed from, itself only if so."""
        found: set[str] = set()
        pending = {name}
        while pending:
            near: set[str] = set()
            for one in self.assigned.get(pending.pop(), []):
                near |= self.locals_in(one.value, set())
            pending |= near - found
            found |= near
        return found

    def locals_in(self, value: Expression, seen: set[str]) -> set[str]:
        """The locals that change in a value, and in the other locals in it."""
        found: set[str] = set()
        for one in whole_parts(value):
            if not isinstance(one, Variable) or one.name in seen:
                continue
            seen.add(one.name)
            ends = (end for loop in self.counts.get(one.name, []) for end in (loop.start, loop.stop))
            inner = [self.values[one.name]] if one.name in self.values else list(ends)
            for other in inner:
                if isinstance(other, Expression):
                    found |= self.locals_in(other, seen)
            if one.name in self.assigned:
                found.add(one.name)
        return found


def whole_parts(value: Expression) -> Iterator[Expression]:
    """The whole numbers that a whole number is computed from."""
    match value:
        case Unary(a=a):
            yield from whole_parts(a)
        case Operation(a=a, b=b) | Choice(a=a, b=b):
            yield from whole_parts(a)
            yield from whole_parts(b)
        case Call(function=function, arguments=(a, _)) if function.origin is whole_quotient:
            yield from whole_parts(a)
        case Variable():
            yield value


def largest_whole(growths: Sequence[Growth]) -> Growth:
    return Growth(max(one.factor for one in growths), max(one.more for one in growths))


def growth_of(sign: str, a: Growth, b: Growth) -> Growth:
    """What a sum, difference or product is at most."""
    if sign != "*":
        return Growth(a.factor + b.factor, a.more + b.more)
    if a.factor and b.factor:
        return Growth(Fraction(ENDLESS), Fraction(ENDLESS))
    return Growth(a.factor * b.more + b.factor * a.more, a.more * b.more)


def result_interval(sign: str, a: Interval, b: Interval) -> Interval:
    """The interval of a sum, difference or product."""
    if sign == "+":
        return a[0] + b[0], a[1] + b[1]
    if sign == "-":
        return a[0] - b[1], a[1] - b[0]
    products = [x * y for x in a for y in b]
    return max(-ENDLESS, min(products)), min(ENDLESS, max(products))


def hull(intervals: Sequence[Interval]) -> Interval:
    return min(low for low, _ in intervals), max(high for _, high in intervals)
