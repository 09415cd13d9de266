"""Plain Python as LLVM's text: compiled, it gives what Python gives, and says what it cannot have."""

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
from hydroservo.engine.compiling import Compiled, compiled
from hydroservo.engine.flat import written
from hydroservo.engine.lower.source import found_definition
from hydroservo.engine.native import CompileError, RunError


class Pair(NamedTuple):
    a: float
    b: float = 2.0

    def total(self, scale: float = 1.0, *, plus: float = 0.0) -> float:
        return scale * (self.a + self.b) + plus


class Nest(NamedTuple):
    pair: Pair
    law: Any = None


def quotients(x: float, y: float, i: int, j: int) -> tuple[Any, ...]:
    return x // y, x % y, i // j, i % j, i / j, x * i, i - j, x // j, i % y


def powers(x: float, i: int) -> tuple[Any, ...]:
    return x**2, x**-1, i**2, i**3, i**0, x**0


def bits(i: int, j: int) -> tuple[Any, ...]:
    return i & j, i | j, i ^ j, ~i, i >> 3, (i & 255) << 4, -i, abs(i), i > 3 | j


def comparisons(x: float, y: float, i: int) -> tuple[Any, ...]:
    return x < y <= 3.0 < i, x != y, x == i, not x, (x < y) & (i > 0), x in (1.0, y), i not in (1, 2)


def choices(x: float, y: float, i: int) -> tuple[Any, ...]:
    return x and y, x or y, x if i > 2 else i, min(x, y, 3), max(x, y), abs(x), (x > 0.0 and y > 0.0) + i


def casts(x: float, i: int) -> tuple[Any, ...]:
    return int(x), float(i), bool(i), bool(x), math.floor(x), math.ceil(x), round(x), math.isnan(x), -x, +i


def sums(x: float, n: int) -> tuple[Any, ...]:
    total: float = 0
    for k in range(n % 7):
        if k == 4:
            continue
        total += x * k
    down = 0
    for k in range(n % 5, -3, -2):
        down = 10 * down + k
    return total, down


def searched(x: float, n: int) -> tuple[Any, ...]:
    found, i = False, 0
    while True:
        i += 1
        if i * 0.5 > x:
            found = True
            break
        if i > 20:
            return i, None, found
    for j in range(n % 9):
        if j * j > 10:
            last = -j
            break
    else:
        last = 100
    return i, None, found if last < 0 else i > 3


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
    found: Any = ()
    for i, (a, b) in enumerate(zip((x, y, 1.0), reversed((x, y, 2)), strict=False)):
        if i == 2:
            continue
        found = (*found, a * b)
    return (*found, len(found), found[-1], found[:1])


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
    p = block.pair
    known = isinstance(p, Pair) and hasattr(block, "law") and block.law is not None
    return p.total(), p.total(2.0), p.total(plus=y), block.law.total(), Pair.total(p, x), known


def late(x: float, n: int) -> float:
    for i in range(1 + n % 3):
        y = x * i
    return y


def indexed(x: float, i: int) -> Any:
    return (x, 1.0, 2.0 * x)[i % 3]


RAISING = """
def raising(x):
    if x > 0.0:
        raise ValueError(f"{x} is too large")
    assert x > -3.0
    return x
"""


FUNCTIONS = [bits, called, casts, choices, comparisons, early, indexed, late, nested, powers]
FUNCTIONS += [quotients, searched, sums, unrolled]
NUMBERS = {
    "float": st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-100),
    "int": st.integers(-1000, 1000),
}


@cache
def machine(function: Callable[..., Any]) -> Compiled:
    return compiled(function)


def same(a: Any, b: Any) -> bool:
    """The same types and bits."""
    if isinstance(a, tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and repr(a) == repr(b)


@pytest.mark.parametrize("function", FUNCTIONS)
@given(data=st.data())
def test_it_gives_what_python_gives(function: Callable[..., Any], data: st.DataObject) -> None:
    hints = {name: hint for name, hint in function.__annotations__.items() if name != "return"}
    given_ = [data.draw(NUMBERS[hint.__name__]) for hint in hints.values()]
    try:
        expected = function(*given_)
    except ZeroDivisionError:
        return
    found = machine(function)(*given_)
    assert same(promoted(expected, found), found), (given_, expected, found)


def promoted(expected: Any, found: Any) -> Any:
    """What Python gives, a whole number as float where another branch gives one."""
    if isinstance(expected, tuple):
        parts = [promoted(*pair) for pair in zip(expected, found, strict=True)]
        return tuple(parts) if type(expected) is tuple else type(expected)(*parts)
    return type(found)(expected) if isinstance(expected, (bool, int)) and found is not None else expected


def test_a_division_by_zero_is_infinite_or_none() -> None:
    assert machine(quotients)(1.0, 0.0, 5, 0)[0] == math.inf
    assert machine(quotients)(1.0, 1.0, 5, 0)[2:5] == (0, 0, math.inf)
    assert math.isnan(machine(quotients)(0.0, 0.0, 5, 1)[1])


def test_what_is_raised_is_an_error() -> None:
    raising = compiled(written(RAISING, {}, "raising"))
    assert raising(-1.0) == -1.0
    for x in (1.0, -3.0):
        with pytest.raises(RunError, match="a block raised an exception"):
            raising(x)


def test_arrays_are_read_and_written_within_their_bounds() -> None:
    def moved(rows: Any, i: int, j: int) -> float:
        rows[i, j] = rows[-1][0] + len(rows) + rows.shape[1] * rows.size
        total = 0.0
        for row in rows:
            total += row[1]
        return total

    rows = np.arange(6.0).reshape(2, 3)
    expected = np.array([[0.0, 1.0, 2.0], [3.0, 23.0, 5.0]])
    assert compiled(moved)(rows, 1, -2) == 24.0
    assert rows.tolist() == expected.tolist()
    for i, j in ((2, 0), (0, 3), (-3, 0), (0, -4)):
        with pytest.raises(RunError):
            compiled(moved)(rows, i, j)


def test_a_switch_that_is_known_decides_what_is_compiled() -> None:
    switch = True

    def chosen(x: float) -> float:
        return x if switch else x.no_such_thing  # type: ignore[attr-defined, no-any-return]

    assert compiled(chosen)(3.0) == 3.0


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


def endless(x: float) -> Any:
    return endless(x) if x > 0.0 else ops.absolute(x)


def caught(x: float) -> Any:
    try:
        return 1.0 / x
    except ZeroDivisionError:
        return 0.0


def unbound(x: float) -> Any:
    if x > 0.0:
        y = x
    return y


REFUSED = {
    lists: "a list, a dict or a string needs memory",
    texts: "a list, a dict or a string needs memory",
    unknown: "compiled code does not support sorted((x, 1.0))",
    fields: "c is neither a field nor a method of Pair",
    lacking: "Pair lacks a",
    unlike: "y is a Pair or None under one name",
    endless: "endless is a function of a module",
    caught: "compiled code does not support 'try:'",
    unbound: "y may have no value here",
}


@pytest.mark.parametrize("function", REFUSED)
def test_what_it_cannot_have_is_said_with_its_place(function: Callable[..., Any]) -> None:
    with pytest.raises(CompileError, match=f"^{re.escape(REFUSED[function])}") as error:
        compiled(function)(1.0)
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
    assert found_definition(names["least"], names["least"].__code__).arguments.args[1].arg == "y"


def test_a_text_that_is_not_what_was_loaded_is_refused() -> None:
    space: dict[str, Any] = {}
    exec(compile("def f(x): return x", __file__, "exec"), space)
    with pytest.raises(CompileError, match=r"the text of f in .*test_lower.py is not the code that runs"):
        compiled(space["f"])(1.0)
