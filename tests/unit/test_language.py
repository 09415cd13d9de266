"""Plain Python as blocks have it: compiled it gives what Python gives, and what it cannot have is said."""

import ast
import linecache
import math
import re
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import ops
from hydroservo.engine.compiling import Compiled, compiled_function
from hydroservo.engine.native import CompileError, RunError
from hydroservo.language.source import definition


class Pair(NamedTuple):
    a: float
    b: float = 2.0

    def total(self, scale: float = 1.0, *, plus: float = 0.0) -> float:
        return scale * (self.a + self.b) + plus


class Nest(NamedTuple):
    pair: Pair
    law: Any = None


class Rows(NamedTuple):
    table: Any

    def sum(self, scale: float) -> float:
        total = 0.0
        for i in range(len(self.table)):
            total += self.table[i, 1] * scale + self.table.shape[1] + 0.5 * self.table.size
        return total + self.table[-1, 0]

    def beyond(self, scale: float) -> float:
        total = 0.0
        for i in range(3):
            total += self.table[i, 1]
        return total


def sum_of_rows(table: Any, count: int) -> float:
    total = 0.0
    for i in range(count):
        total += table[i, 1] + len(table) * table.shape[1] + 0.5 * table.size
    return total + table[-1, 0]


def quotients(x: float, y: float, i: int) -> tuple[Any, ...]:
    return x // y, x % y, i // 7, i % 7, i / 8, x * i, i - 3, x // i, i % y, 2**5 // 3, 7 % 4


def comparisons(x: float, y: float, i: int) -> tuple[Any, ...]:
    return x < y <= 3.0 < i, x != y, x == i, not x, (x < y) & (i > 0), x in (1.0, y), i not in (1, 2)


def choices(x: float, y: float, i: int) -> tuple[Any, ...]:
    first = x if i > 2 else y
    return first, x > 0.0 and y > 0.0, x < 0.0 or not y, min(x, y, 3.0), max(x, y), abs(x), abs(i), max(i, 3)


def casts(x: float, i: int) -> tuple[Any, ...]:
    return (
        float(i),
        bool(i),
        bool(x),
        math.isnan(x),
        math.sqrt(abs(x)),
        -x,
        +i,
        (x > 0.0) * 2.5,
        i + (x > 1.0),
    )


def sums(x: float, n: int) -> tuple[Any, ...]:
    total = 0.0
    for k in range(n % 7):
        if k == 4:
            continue
        total += x * k
    down = 0
    for k in range(n % 5, -3, -2):
        down = down + k
    return total, down


def searched(x: float, n: int) -> tuple[Any, ...]:
    found, i = False, 0
    while True:
        i += 1
        if i * 0.5 > x:
            found = True
            break
        if i > 20:
            return i, 0, found
    last = 100
    for j in range(n % 9):
        if j * j > 10:
            last = -j
            break
    while i < 30 and last > 0:
        i += 3
        if i % 2 == 0:
            continue
        last -= 40
    return i, last, found if last < 0 else i > 3


def nested(x: float, n: int) -> tuple[Any, ...]:
    s = Pair(x)
    grid = 0.0
    for i in range(n % 4):
        for j in range(i, 3):
            if j == 2 and x > 0.0:
                break
            grid += s.a * i - j
            s = Pair(s.b, s.a + j)
    return s, grid


def unrolled(x: float, y: float) -> tuple[Any, ...]:
    total = 0.0
    for i, (a, b) in enumerate(zip((x, y, 1.0), reversed((x, y, 2.0)), strict=True), start=1):
        for j in range(3):
            if j == 2:
                break
            total += a * b + i
    row = (*Pair(x, y), total, *(x, y)[:1])
    [c, d] = row[1:3]
    return (*row, len(row), row[-1], c, d)


def held(x: float, y: float) -> tuple[Any, ...]:
    """What a loop goes through, and methods that were taken, stay as they were."""
    b, total, s = y, 0.0, Pair(x, y)
    for v in (x, b):
        b = 10.0
        total += v
    for v in s:
        s = Pair(100.0, v)
        total += v
    both = (s.total, s.total)
    s, f = Pair(y, x), s.total
    return total + b, s, both[0](), f()


def signs(x: float, y: float) -> tuple[Any, ...]:
    ways = (x, y) if x > y else (y, x)
    pair = (y, x)
    if x < 0.0:
        pair = (x, 1.0)
    t = ()
    t += (x,)
    return +x, -(x > 0.0), ways, pair, (x > 0.0) ^ (y > 0.0), t, 10.0**2


class Limited(NamedTuple):
    limit: float
    law: Any = None

    def within(self, x: float, limit: Any = None) -> float:
        if limit is None:
            limit = self.limit
        return ops.minimum(x, limit)

    def both(self, x: float) -> tuple[Any, ...]:
        return self.within(x), self.within(x, 1.0), bool(self.law), self.law is None


def early(x: float, i: int) -> Pair:
    if x < 0.0:
        return Pair(0.0, b=x)
    if i > 3:
        x = x + 1
    elif i < 0:
        return Pair(b=1.0, a=x)
    return Pair(x)


def called(x: float, y: float) -> tuple[Any, ...]:
    block = Nest(Pair(x, y), Pair(1.0))
    p, nothing = block.pair, Nest(Pair(x)).law
    known = isinstance(p, Pair) and hasattr(block, "law") and block.law is not None and nothing is None
    return p.total(), p.total(2.0), p.total(plus=y), block.law.total(), known


FUNCTIONS = [
    called,
    casts,
    choices,
    comparisons,
    early,
    held,
    nested,
    quotients,
    searched,
    signs,
    sums,
    unrolled,
]
NUMBERS = {
    "float": st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-100),
    "int": st.integers(-1000, 1000),
}


@cache
def machine(function: Callable[..., Any]) -> Compiled:
    return compiled_function(function)


def same(a: Any, b: Any) -> bool:
    """The same types and bits."""
    if isinstance(a, tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and repr(a) == repr(b)


@pytest.mark.parametrize("function", FUNCTIONS)
@given(data=st.data())
def test_it_gives_what_python_gives(function: Callable[..., Any], data: st.DataObject) -> None:
    hints = {name: hint for name, hint in function.__annotations__.items() if name != "return"}
    numbers = [data.draw(NUMBERS[hint.__name__]) for hint in hints.values()]
    try:
        expected = function(*numbers)
    except ZeroDivisionError:
        return
    found = machine(function)(*numbers)
    assert same(expected, found), (numbers, expected, found)


def test_a_division_by_zero_is_infinite_or_none() -> None:
    assert machine(quotients)(1.0, 0.0, 5)[0] == math.inf
    assert machine(quotients)(-1.0, 1.0, 0)[7] == -math.inf
    assert math.isnan(machine(quotients)(0.0, 0.0, 5)[1])


def test_an_argument_may_be_missing() -> None:
    block = Limited(2.5)
    for x in (3.0, 2.0, -1.0):
        assert machine(Limited.both)(block, x) == block.both(x)


def test_a_switch_is_not_a_number() -> None:
    found = [machine(with_law)(Nest(Pair(1.0), law)) for law in (True, 1, 1.0)]
    assert [type(nest.law) for nest in found] == [bool, int, float]


def with_law(nest: Nest) -> Nest:
    return nest


def test_arrays_are_read_within_their_bounds() -> None:
    rows = Rows(np.arange(6.0).reshape(2, 3))
    assert machine(Rows.sum)(rows, 2.5) == rows.sum(2.5)
    with pytest.raises(CompileError, match=r"self.table\[i, 1\]': a whole number that may outgrow 0 to 1"):
        machine(Rows.beyond)(rows, 2.5)
    assert machine(sum_of_rows)(rows.table, 2) == sum_of_rows(rows.table, 2)
    with pytest.raises(RunError, match="a block raised an exception"):
        machine(sum_of_rows)(rows.table, 3)


def test_what_is_known_decides_what_is_compiled() -> None:
    switch, count = True, 3

    def chosen(x: float) -> float:
        total = x if switch else x.no_such_thing  # type: ignore[attr-defined]
        for _ in range(count):
            total = 2.0 * total
        return total

    assert compiled_function(chosen)(3.0) == 24.0


def lists(x: float) -> Any:
    return [x]


def texts(x: float) -> Any:
    return f"{x}"


def unknown(x: float) -> Any:
    return sorted((x, 1.0))


def fields(x: float) -> Any:
    return Pair(x).c  # type: ignore[attr-defined]


def lacking(x: float) -> Any:
    return Pair(b=x).a  # type: ignore[call-arg]


def unlike(x: float) -> Any:
    y = None
    if x > 0.0:
        y = Pair(x)
    return y.total()  # type: ignore[union-attr]


def mixed(x: float) -> Any:
    return x if x > 0.0 else 0


def squared(x: float) -> Any:
    return x**2


def rounded(x: float) -> Any:
    return int(x)


def sine(x: float) -> Any:
    return math.sin(x)


def endless(x: float) -> Any:
    return endless(x) if x > 0.0 else ops.absolute(x)


def caught(x: float) -> Any:
    try:
        return 1.0 / x
    except ZeroDivisionError:
        return 0.0


def raised(x: float) -> Any:
    if x > 0.0:
        raise ValueError
    return x


def unbound(x: float) -> Any:
    if x > 0.0:
        y = x
    return y


def unsure(x: float) -> Any:
    for i in range(3):
        y = x * i
    return y


def twice_read(x: float) -> Any:
    pairs = zip((x, 1.0), (2.0, x), strict=True)
    return sum_of_pairs(pairs)


def sum_of_pairs(pairs: Any) -> float:
    return 0.0


def nothing(x: float) -> Any:
    n = None
    for _ in range(3):
        n = None
    return x if n is None else 0.0


def unordered(x: float) -> Any:
    return x if x > None else 0.0  # type: ignore[operator]


def no_number(x: float) -> Any:
    return x * int(math.nan)


def complex_number(x: float) -> Any:
    return x * (-8) ** 0.5


def field_changed(x: float) -> Any:
    p = Pair(x)
    p.a, q = x, 1.0  # type: ignore[misc]
    return q


def outgrown(x: float) -> Any:
    n = 1
    for _ in range(60):
        n = n * 3
    return x * n


REFUSED = {
    lists: "'[x]' is not supported",
    texts: "f'{x}'",
    unknown: "sorted((x, 1.0)) is not supported",
    fields: "Pair has neither a field nor a method 'c'",
    lacking: "Pair is given no a",
    unlike: "y is None and something else in turn; give it two names",
    mixed: "a choice of a float and a whole number; write 1.0 and not 1 for a float",
    squared: "a ** b of floats is not supported; write x * x, or use ops.power",
    rounded: "int of a float is not supported; use ops.floor or ops.nearest",
    sine: "math.sin(x) is not supported; use ops.sin",
    endless: "endless(x) is a function of a module",
    caught: "'try:' is not supported",
    raised: "'raise ValueError' is not supported; return math.nan",
    unbound: "y may have no value yet",
    unsure: "y may have no value yet",
    twice_read: "pairs can be read once alone; loop over it directly",
    nothing: "n is None and something else in turn; give it two names",
    unordered: "a number is needed here",
    no_number: "int(math.nan) is not supported",
    complex_number: "'(-8) ** 0.5' is not supported",
    field_changed: "only names can be assigned to",
    outgrown: "'n * 3': a whole number that may outgrow 64 bits; use floats",
}


@pytest.mark.parametrize("function", REFUSED)
def test_what_it_cannot_have_is_said_with_its_place(function: Callable[..., Any]) -> None:
    with pytest.raises(CompileError, match=f"^.?{re.escape(REFUSED[function])}") as error:
        compiled_function(function)(1.0)
    file, line = error.value.places[0]
    first = function.__code__.co_firstlineno
    assert file == __file__
    assert first < line <= first + 4


def test_a_cell_of_a_notebook_is_compiled_statement_by_statement() -> None:
    """IPython does so, and Python then calls what the cell imports in other words."""
    text = "from hydroservo import ops\n\ndef least(x, y):\n    return ops.where(x < y, x, y)\n"
    file, names = "<a cell>", {}
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    for one in ast.parse(text).body:
        exec(compile(ast.Module([one], []), file, "exec"), names)
    assert definition(names["least"]).args.args[1].arg == "y"


def test_a_text_that_is_not_what_was_loaded_is_refused() -> None:
    space: dict[str, Any] = {}
    exec(compile("def f(x): return x", __file__, "exec"), space)
    problem = r"the text of f in .*test_language.py is not the code that runs"
    with pytest.raises(CompileError, match=problem):
        compiled_function(space["f"])(1.0)
