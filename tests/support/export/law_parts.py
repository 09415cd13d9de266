"""What random laws are made of.

In these texts ``{x}`` and ``{y}`` stand for floats, ``{m}`` and ``{n}`` for whole numbers, ``{so}`` for a
condition, ``{p}`` for a Pair, ``{t}``, ``{t2}`` and ``{w}`` for locals that are given a float or a whole
number, ``{i}`` for a counter, ``{count}`` for how far it counts, ``{last}`` for a return, and ``{block}``,
``{other}``, ``{third}`` and ``{short}`` for statements.
"""

HEAD = '''\
"""A law of a test."""

import functools
import math
from decimal import Decimal
from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from hydroservo import ops
from hydroservo.core.block import Field
from hydroservo.core.time_series import TimeSeries

SLOPE = 2.5
ROOT = np.sqrt(2.0)
TURNS = 4
LEVEL = {level}
EDGE = {edge}
'''
LEVELS = (
    "0.1", "-0.0", "1e308", "5e-324", "2.0**53", "math.nan", "math.inf", "-math.inf", "math.pi", "1 / 3",
    "np.float64(0.1)", "np.finfo(float).eps",
)  # fmt: skip
EDGES = (
    "3", "-1", "0", "2**31 - 1", "2**31", "-(2**31)", "2**32", "2**53", "2**53 - 1", "-(2**53)",
)  # fmt: skip
ODD_LEVELS = (
    "np.float32(0.1)", "Fraction(1, 3)", "Decimal('0.1')", "0.5j", "np.array(0.5)", "(0.5, 1.5)", "'0.5'",
    "None", "7", "True",
)  # fmt: skip
ODD_EDGES = (
    "2**62", "2**63 - 1", "-(2**63)", "2**63", "10**30", "True", "np.int64(3)", "np.int32(2**31 - 1)",
    "np.bool_(True)", "0.5",
)  # fmt: skip
FIRST_STATES = (
    "LawState(0.0, 0.5, Inner(1.0, -0.0))", "LawState(-0.0, self.gain, Inner(self.band.high, math.nan))",
    "LawState(u=1.0 / self.gain, inner=Inner(2.0 * self.turns, 0.0), beside=float(self.table[2]))",
    "LawState(0.0, 5e-324, Inner(math.inf if self.reverse else -1e308, ops.sqrt(self.gain)))",
)  # fmt: skip

# Classes, functions and methods, each in a law's text only if something there names it.
RECORDS = '''\
RECORD = TimeSeries(
    np.array([-2.0, 0.5, 3.0]),
    np.array([[0.5, -0.25], [0.0, 1.0], [2.0, -3.0], [1.0, 4.0]]),
)


class Pair(NamedTuple):
    left: float
    right: float

    def total(self):
        return self.left + self.right

    def swapped(self):
        return Pair(self.right, self.left)


class Nest(NamedTuple):
    pair: Pair
    depth: float = 1.0

    def deeper(self, by=0.5):
        return Nest(self.pair.swapped(), self.depth + by)


class Band(NamedTuple):
    """A band."""

    low: float = -1.0
    high: float = 2.0
    steps: int = 3

    def within(self, x):
        if x < self.low:
            return self.low
        elif x > self.high:
            return self.high
        return x


class Inner(NamedTuple):
    memory: Annotated[float, Field("V", "number kept")]
    other: Annotated[float, Field("V", "another one")]


class LawState(NamedTuple):
    u: Annotated[float, Field("V", "command")]
    beside: Annotated[float, Field("V", "number beside it")]
    inner: Inner


def same(f):
    return f


def marking(f):
    f.mark = 1
    return f


def defaulting(f):
    f.__defaults__ = (2.0,)
    return f


def wrapping(f):
    @functools.wraps(f)
    def inner(self, x):
        return f(self, x) + 1.0

    return inner


def plainly(f):
    @functools.wraps(f)
    def inner(self, x):
        return x

    return inner


def replacing(f):
    return twice


def twice(self, x):
    return 2.0 * x


def outside(x):
    return x
'''
DECORATORS = (
    "same", "marking", "defaulting", "wrapping", "plainly", "replacing", "staticmethod", "classmethod",
    "property", "functools.cache", "functools.lru_cache",
)  # fmt: skip
METHODS = """\
def pair(self, a, b):
    return a + b, a - b

def counted(self, n):
    u = 0.0
    for _ in range(3):
        u = u + n
        n = n + 1
    return u

def early(self, a, b=0.5):
    for i in range(4):
        if a > b + i:
            return a - 1.0 * i
        a = a + 0.5
    return b

def turned(self, x):
    n = 0.0
    while x < 0.0:  # never ends
        n = n + 1.0
    return Pair(x, n - x)

def ways(self, x, n=2, up=True, *, k=1):
    return x

def branched(self, a, n=2, up=True):
    if up and a > 1.0:
        return a * n
    if not up:
        n = n + 1
    elif a < -1e6:
        return -1.0
    while n > 0 and a < 100.0:
        a = a + n
        n = n - 1
    return a

def declared(self, x: float, n: int = 3) -> float:
    y = x * x * x
    return ops.where(x > 0.0, y, -x) * n

def whole(self, n, by=1):
    if n > 3:
        return n - by
    return n + by * n

def level(self, i):
    return self.gain * i - float(self.table[-1])

def high(self, x, /, least=3.0):
    if x > 1e6:
        return True
    return x > least and not self.reverse

def found(self, table, i, band):
    return table[i] * band.high - band.within(table[-1])

def itself(self):
    return self

def swept(self, x):
    u = x
    for i in range(2):
        for j in range(3):
            u = 0.5 * u + self.grid[i, j]
    return u
"""

REALS = (
    "a", "b", "c", "a", "b", "c", "y.velocity", "r.value", "self.gain", "SLOPE", "ROOT", "0.5", "-3.0", "dt",
    "s.u", "s.beside", "s.inner.memory", "p.left", "p.right", "q.pair.left", "self.band.high",
    "self.table[2]", "float(self.table[-1])", "self.grid[1, 2]", "math.pi", "1e-9",
)  # fmt: skip
EXTREMES = (
    "-0.0", "math.nan", "math.inf", "1e308", "5e-324", "LEVEL",
)  # fmt: skip
WHOLES = (
    "k", "n", "k", "n", "2", "-3", "self.turns", "TURNS", "1000000000", "46341", "(1 << 40)", "7", "0",
    "self.band.steps", "2147483647", "2147483648", "-2147483648", "4294967296", "self.table.size", "EDGE",
)  # fmt: skip
REAL_FORMS = (
    "({x} + {y})", "({x} - {y})", "{x} * {y}", "-({x} - {y})", "({x} / (1.0 + {y} * {y}))", "({x} / {y})",
    "({m} / 3)", "ops.maximum({x}, {y})", "ops.minimum({x}, {y})", "ops.where({x} > {y}, {x}, -{y})",
    "({x} if {so} else {y})", "ops.clip({x}, -1.0, {y})", "ops.sign({x})", "ops.sqrt({x})", "ops.floor({x})",
    "ops.nearest({x})", "ops.absolute({x})", "ops.copysign({x}, {y})", "ops.power(ops.absolute({x}), 0.5)",
    "ops.tanh({x})", "ops.signed_power({x}, 0.5)", "(self.turned({x}).left if {x} >= 0.0 else {y})",
    "({y} if {x} < 0.0 else self.turned({x}).right)", "Pair({x}, {y}).right", "Pair({x}, {y}).left",
    "Pair(right={x}, left={y}).total()", "{x} + self.counted({m})", "({x} * {m})", "({m} * {n} * 1.0)",
    "float({m})", "self.early({x}, {y})", "self.early({x})", "self.early(b={x}, a={y})", "self.branched({x})",
    "self.branched({x}, {m})", "self.branched({x}, up=False)", "self.branched({x}, n=3, up={so})",
    "self.declared({x})", "self.declared({x}, {m})", "self.swept({x})", "self.band.within({x})",
    "self.series.value({x})", "self.series.rate({x})", "(p if {so} else self.turned(1.0)).left",
    "ops.where({so}, p, Pair({x}, {y})).right", "q.deeper().pair.right", "q.deeper(by={x}).depth",
    "ops.sqrt({m})",
    "self.found(self.table, 2, self.band)", "self.found(self.table, 0, Band(-2.0, {x}, 3))",
    "self.itself().gain", "(1.0 if self.high({x}) else {y})",
)  # fmt: skip
WHOLE_FORMS = (
    "({m} + {n})", "({m} - {n})", "({m} * {n})", "({m} // 3)", "({m} // 1000003)", "-{m}",
    "({m} if a > b else {n})", "self.whole({m})", "self.whole({m}, by={n})",
    "((46341 if a > b else 2147483647) * (1000000000 if flag else -3))",
    "((2 if flag else 2147483647) + (1 if a > b else 2147483647))",
    "((2147483648 if a > b else {m}) * 4294967295 // 1000003)",
    "((1023 if flag else -1023) * 9007199254740991 // 1000003)",
)  # fmt: skip
CONDITIONS = (
    "flag", "self.reverse", "a > b", "ops.isnan(a)", "ops.isfinite(b)", "-2.0 < b <= c < a",
)  # fmt: skip
CONDITION_FORMS = (
    "{x} > {y}", "not {x} <= {y}", "({x} < {y} or {y} > 1.0)", "{x} < {y} < 2.0", "{m} > {n}",
    "0.0 <= {x} <= {y} < 9.0", "-9.0 < {x} < 9.0 > {y} > -1.0", "{m} < {n} <= 7", "{x} == {y}", "{x} != {y}",
    "{m} != {n}", "{x} < {m}",
    "({x} >= 0.0 and self.turned({x}).right > {y})", "({x} < 0.0 or self.turned({x}).left > {y})",
    "({m} == {n} and {x} > {y})", "(self.reverse or {x} > {y})", "(flag and {x} > {y})", "not flag",
    "not ({x} < 0.0 or not self.turned({x}).left > {y})", "({x} > 1.0 if flag else {y} > 2.0)",
    "self.high({x})", "(self.high({x}, {y}) or self.high({y}, least=-1.0))",
)  # fmt: skip
RECORD_FORMS = (
    "Pair({x}, {y})", "Pair(right={x}, left={y})", "self.turned(ops.absolute({x}))", "p.swapped()", "q.pair",
    "(Pair({x}, {y}) if {so} else p)", "(self.turned({x}) if {x} >= 0.0 else p)",
    "ops.where({so}, p, Pair({x}, {y}))",
)  # fmt: skip
SIMPLE = (
    "{t} = {x}", "{t} = {x}", "{t} = {x}", "{t} += {x}", "{t} -= {x}", "{t} *= {x}", "{t} /= 1.0 + {x} * {x}",
    "{t}: float = {x}", "{w} = {m}", "{w} += {m}", "{w} -= {m}", "{w} *= {m}", "{w} //= 3", "flag = {so}",
    "flag = flag and {so}", "flag = not flag", "p = {p}", "p = {p}", "{t} = p.left - p.right",
    "q = Nest({p}, {x})", "q = q.deeper({x})", "{t}, {t2} = p", "a, b = {x}, {y}", "a, b = b, a",
    "{t} = {t2} = {x}", "c, (a, b) = {x}, (b, {y})", "b, _ = self.pair({x}, {y})", "a, c = self.pair({x}, c)",
    "{w} = n - k", "{t}: float", "pass", '"""A text."""', "s = LawState({x}, s.u, s.inner)",
    "s = LawState(s.u, {x}, Inner(s.beside, {y}))", "f = p.total\np = {p}\n{t} = f()",
)  # fmt: skip
AROUND = (
    "for {i} in range(3):\n    {t} = {t} + {x}\n    {t}: float\n{short}",
    "if {so}:\n{block}", "if {so}:\n{block}\nelse:\n{other}",
    "if {so}:\n{block}\nelif {so}:\n{third}\nelse:\n{other}", "if {so}:\n{short}\n    {last}",
    "if self.reverse:\n{block}\nelse:\n{other}", "for {i} in range({count}):\n{block}",
    "for {i} in range({count}):\n{block}",
    "for {i} in range({count}):\n    if {so}:\n        {last}\n{short}",
    "w = {x}\nw = w * w\nwhile 1.0 < w < 1e9:\n{block}\n    w = 0.25 * w",
    "w = 9.0\nwhile w > 1.0 and not (a > w or k > 5):\n{block}\n    w = w - 2.5",
    "m = self.turns\nwhile m > 0:\n{block}\n    m -= 1",
    "for {i} in range(self.table.size):\n    {t} += self.table[{i}]\n{short}",
    "for {i} in range(2):\n    {t} = self.grid[{i}, {i} + 1] + self.level({i})",
)  # fmt: skip
COUNTERS = (
    "i", "j", "i", "j", "i", "j", "i", "j", "_", "k", "m",
)  # fmt: skip
COUNTS = (
    "3", "self.turns", "n - n + 2", "1", "0", "5", "i", "40", "k - k", "-2",
)  # fmt: skip

# Locals with names that mean something elsewhere, and what is mostly refused: one a law at most.
NAMES = (
    "double", "int64_t", "INFINITY", "NAN", "switch", "self_", "state", "law_step", "parameters",
    "measurement", "x1", "\u03bc", "ops_maximum", "own_law_step", "slope", "value", "chosen", "holds",
    "record", "left", "M_PI", "I", "main", "t", "__x",
)  # fmt: skip
SHADOWS = (
    "SLOPE = a", "ROOT = 2.0", "TURNS = 3", "LEVEL = 1.0", "EDGE = 2", "math = Pair(1.0, 2.0)", "dt = 0.5",
    "float = 2.0", "range = 3.0", "ops = p", "y = r", "r = y", "min = 1.0", "self = self.band",
    "Pair = Inner",
)  # fmt: skip
ODD = (
    "{t} = LEVEL * {x}", "{t} = {x} - LEVEL", "{w} = EDGE", "{w} = {m} - EDGE", "{w} = EDGE // 3 - EDGE",
    "{t} = 1.0 * (EDGE // 7)", "if {x} < EDGE:\n{block}", "if LEVEL:\n{block}", "if EDGE > {m}:\n{block}",
    "for i in range(EDGE):\n    if i > 9:\n        {last}", "{t} = self.decorated({x})",
    "{t} = self.decorated({x})", "{t} = self.decorated({x})", "{t} = self.decorated()",
    "{t} = self.decorated", "s = s._replace(u={x})", "p = p._replace(left={x})", "{t} = p[0]",
    "{t} = {x} % 2.0", "{w} = {m} % 7", "{w} = {m} // -3", "{w} = {m} << 2",
    "{w} = 9223372036854775807 - {m}", "{w} = {m} + 9007199254740992", "{w} = -9007199254740992 - {m}",
    "{t} = {x} + 9007199254740993", "{w} = {m} & 255", "{w} %= 5", "{t} = abs({x})", "{t} = max({x}, {y})",
    "{t} = {x} ** 2", "{t} = {x} // 0.5", "{t} = +{x}", "{w} = ~{m}", "{t} = math.sqrt({x})",
    "{t} = ({x} if {so} else {m})", "{t} = ({m} if {so} else {x})", "{t} = (1 if {so} else {x})",
    "{t} = -(0 if {so} else {x})", "{t} = (1000000007 if {so} else {x})\n{t2} = {t} * {t} * {t}",
    "{t} = ops.where({so}, 3, {x})", "{t} = -ops.maximum({x}, 0)", "{t} = -ops.clip({x}, 0, 10)",
    "{t} = ops.minimum({m}, {x}) * {m}", "{t} = ops.maximum({m}, {n}) * {m} * 1.0", "p = Pair({m}, {x})",
    "p = Pair(3, 0)\n{t} = -p.right * p.left", "p = Pair({so}, 1.0)", "{t} = self.declared({m})",
    "{t} = -self.declared(0)", "{t} = self.early({m}, 1)", "{t} = self.ways({x}, k=2)", "{t} = 1.0 * flag",
    "{t} = 1.0 * (flag + {m})", "{t} = {so}", "{w} = {x}", "flag = {x}", "flag = ({so}) == ({so})", "a = p",
    "p = {x}", "q = p", "for i in range(1, 4):\n{block}", "for i in range(3):\n    break",
    "while {so}:\n    break", "for x in self.table:\n    a = a + x",
    "for i in range(3):\n{short}\nelse:\n{short}", "while True:\n    {last}", "while {so}:\n    {last}",
    "try:\n{short}\nfinally:\n    pass", "global OTHER", "del a", "assert {so}", "a = [{x}]",
    "a = (lambda: {x})()", "a = {{{x}}}", "a = f'{{{x}}}'", "a = {x}, {y}", "a, b, c = p", "a, *_ = {x}, {y}",
    "a = outside({x})", "a = s.missing", "a = self.table[9]", "a = self.table[{m}]", "a = self.table[i]",
    "for k in range(3):\n    k = k - 1\n    a = self.table[k]", "if 0 <= k < 3:\n    a = self.table[k]",
    "a = self.table[{x}]", "a = self.table[self.table.size - 1]", "a = self.table[-3]", "a = self.grid[1]",
    "a = self.grid[0][1]", "a = self.grid.size * 1.0", "a = self.grid.shape[0]", "a = self.grid[-1, -2]",
    "a = self.table.sum()", "a = self.table[0:2]", "a = self.series.knots[1] + self.series.next_knot({x})",
    "a = RECORD.value({x})", "a = (b := {x})", "a = ops.power({x})", "a = ops.random({x})",
    "a = math.tau - np.pi", "a = np.sqrt({x})", "a = ops.copysign(1.0, -math.nan)",
    "x: float = {x}\nx: float\na = x", "return s", "return LawState({x}, 1, s.inner)",
    "return LawState({x}, {y}, {p})", "return {x}", "return {x}, {y}, s.inner", "return",
    "{w} = {m}\nif {w} + 1 == {w} + 1:\n{block}", "if {x} == {x}:\n{block}", "if p == p:\n{block}",
    "if a is b:\n{block}", "import math as mm", "def g(x):\n    return x",
    "match a:\n    case _:\n        pass", "with a:\n    pass", "raise ValueError", "a = p.count(1.0)",
    "a = getattr(p, 'left')", "a = Pair(*p).left", "a = type(p)({x}, 1.0).left", "a = self.__class__().gain",
    "a = Pair.total(p)", "a = ops.sign", "a = self.turns.real", "a = (5).bit_length()", "a = {x}.real",
    "a = self.gain.hex()", "return ops.where({so}, s, LawState({x}, {y}, s.inner))",
    "a = self.whole(9223372036854775807) * 0.5",
)  # fmt: skip
