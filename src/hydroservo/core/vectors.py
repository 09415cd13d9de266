"""Vectors and matrices of a fixed size as blocks: records of floats, whose arithmetic is written out.

An array in a block is one memory for all runs and cannot change. A vector is a NamedTuple as every state is,
so that each run has its own, compiled, in lanes and in C, with the same bits.
"""

import linecache
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

from hydroservo.core import ops
from hydroservo.core.field import Field

LONGEST = 50  # terms of a sum in one expression: Python nests them, and compiles no more than some hundreds


def vector(name: str, size: int, field: Field) -> Any:
    """A class of vectors: NamedTuples of the floats ``e1`` to ``en``, with their arithmetic as methods.

    These are ``plus(other)``, ``minus(other)``, ``times(other)``, each by each, ``scaled(factor)``,
    ``clipped(low, high)``, ``filled(number)``, ``with_first(number)``, ``shifted(newest)``, a window of
    samples moved on by one, ``differences()`` from entry to entry, the first from 0,
    ``differences_transposed()``, ``dot(other)`` and ``total()``. Each is written out entry by entry, and that
    text is what is interpreted, compiled and exported. ::

        Weights = vector("Weights", 7, Field("m/s^2", "weight"))

    Args:
        name: under which the calling module has the class.
        size: how many entries there are, at least 2.
        field: what each is; its number is added to the meaning.

    Source: chosen here. Fails where there are many entries: the text grows with them.
    """
    entries = [f"e{i}" for i in range(1, size + 1)]
    made = record(name, [(entry, numbered(field, i)) for i, entry in enumerate(entries, 1)])
    each = [f"self.{entry}" for entry in entries]
    rises = [each[0], *(f"{b} - {a}" for a, b in pairwise(each))]
    transposed = [*(f"{a} - {b}" for a, b in pairwise(each)), each[-1]]
    texts = [
        method("filled", "self, number", result_of(["number"] * size)),
        method("plus", "self, other", result_of(f"self.{e} + other.{e}" for e in entries)),
        method("minus", "self, other", result_of(f"self.{e} - other.{e}" for e in entries)),
        method("times", "self, other", result_of(f"self.{e} * other.{e}" for e in entries)),
        method("scaled", "self, factor", result_of(f"factor * self.{e}" for e in entries)),
        method(
            "clipped", "self, low, high", result_of(f"ops.clip(self.{e}, low.{e}, high.{e})" for e in entries)
        ),
        method("with_first", "self, number", result_of(["number", *each[1:]])),
        method("shifted", "self, newest", result_of(["newest", *each[:-1]])),
        method("differences", "self", result_of(rises)),
        method("differences_transposed", "self", result_of(transposed)),
        sum_method("dot", "self, other", [f"self.{e} * other.{e}" for e in entries]),
        sum_method("total", "self", each),
    ]
    return with_methods(made, "".join(texts), made)


def matrix(name: str, row: Any, product: Any) -> Any:
    """A class of matrices: NamedTuples of the rows ``r1`` to ``rm``, with the method ``times(vector)``.

    Args:
        name: under which the calling module has the class.
        row: the class of vectors that its rows are.
        product: the class of vectors that ``times`` gives, an entry for each row.

    Source: chosen here. Fails where it is large: the text grows with its entries.
    """
    rows = [f"r{i}" for i in range(1, len(product._fields) + 1)]
    made = record(name, [(one, row) for one in rows])
    return with_methods(
        made, method("times", "self, other", result_of(f"self.{one}.dot(other)" for one in rows)), product
    )


def numbered(field: Field, number: int) -> Any:
    """The annotation of one entry."""
    return Annotated[float, replace(field, meaning=f"{field.meaning} {number}")]


def record(name: str, fields: Iterable[tuple[str, Any]]) -> Any:
    """A NamedTuple class in the module that asked for a vector or matrix."""
    made: Any = NamedTuple(name, fields)  # type: ignore[misc]
    made.__module__ = sys._getframe(2).f_globals["__name__"]
    return made


def result_of(entries: Iterable[str]) -> str:
    """A call that makes a vector of entries."""
    return f"Result({', '.join(entries)})"


def method(name: str, arguments: str, value: str, before: Iterable[str] = ()) -> str:
    lines = [*before, f"return {value}"]
    return f"\ndef {name}({arguments}):\n" + "".join(f"    {line}\n" for line in lines) + "\n"


def sum_method(name: str, arguments: str, terms: Sequence[str]) -> str:
    """A method that adds up terms from left to right."""
    parts = [" + ".join(terms[i : i + LONGEST]) for i in range(0, len(terms), LONGEST)]
    sums = [parts[0], *(f"total + {part}" for part in parts[1:])]
    return method(name, arguments, sums[-1], [f"total = {part}" for part in sums[:-1]])


def with_methods(made: Any, text: str, result: type) -> Any:
    """A class with the functions of a text as methods; the text can be read as that of a file can."""
    file = f"<{made.__module__}.{made.__qualname__}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    space: dict[str, Any] = {"__name__": made.__module__, "ops": ops, "Result": result}
    functions: dict[str, Any] = {}
    exec(compile(text, file, "exec"), space, functions)
    for name, function in functions.items():
        function.__qualname__ = f"{made.__qualname__}.{name}"
        setattr(made, name, function)
    return made
