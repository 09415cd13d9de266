"""Blocks and states as plain memory: what compiled kernels take in and give back.

A kernel sees no Python object, only arrays of doubles. For each type of block the text of a small function
is written that makes the block from its numbers, or writes its numbers back.
"""

import linecache
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import FunctionType
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, is_block, leaves, values
from hydroservo.language.functions import array_at

Shape = tuple[Any, ...]
Text = Callable[[str, Any], str]
Place = Callable[[int], str]  # the text of an index


class LeafKind(NamedTuple):
    """What a leaf of a block is: float, an array, a whole number, True or False.

    A whole number, a switch and the shape of an array are part of the code, for they decide what is computed
    at all; but for those that are ``GIVEN``, of which arrays have their number of axes here.
    """

    type: type
    which: Any


FLOAT = LeafKind(float, 0)  # what most are
# Whole numbers, and arrays of a curve, that a kernel is given each time.
GIVEN = {"coefficients", "knots", "periods", "seed", "substeps"}


def block_shape(block: Block) -> Shape:
    """The classes of a block and of all that is in it: what a kernel is compiled for."""
    parts = zip(block._fields, block, strict=True)
    kinds = (block_shape(value) if is_block(value) else leaf_kind(name, value) for name, value in parts)
    return (type(block), *kinds)


def leaf_kind(name: str, value: Any) -> LeafKind:
    if type(value) is float:
        return FLOAT
    if isinstance(value, np.ndarray):
        return LeafKind(np.ndarray, value.ndim if name in GIVEN else value.shape)
    return LeafKind(type(value), 0 if name in GIVEN or not is_whole_kind(value) else int(value))


def is_whole_kind(value: Any) -> bool:
    """True for a whole number or a switch."""
    return isinstance(value, int | np.integer | np.bool_)


def block_numbers(block: Block) -> NDArray[np.float64]:
    """The numbers of a block, arrays left out, in declared order."""
    found = [float(value) for value in values(block) if not isinstance(value, np.ndarray)]
    return np.array(found, dtype=np.float64)


def block_arrays(block: Block) -> NDArray[np.int64]:
    """Address and lengths of each array of a block; the block must outlive their use."""
    table: list[int] = []
    for value in double_arrays(block):
        table += [value.ctypes.data, *value.shape]
    return np.array(table, dtype=np.int64)


def double_arrays(block: Block) -> Iterator[NDArray[np.float64]]:
    for value in values(block):
        if isinstance(value, np.ndarray):
            if value.dtype != np.float64 or not value.flags.c_contiguous:
                path = next(path for path, other in leaves(block) if other is value)
                raise TypeError(f"{path} must be a contiguous array of doubles, not of {value.dtype}")
            yield value


def builder(block: Block) -> FunctionType:
    """A function ``build(numbers, arrays)`` that makes a block of this shape."""
    return constructor("build(numbers, arrays)", block, leaf_positions(block))


def leaf_positions(block: Block, at: Place = str) -> Text:
    """Where each leaf stands in the numbers and in the table of arrays of a block.

    ``at`` gives the index of the i-th number.
    """
    places: dict[str, str] = {}
    number, place = 0, 0
    for path, value in leaves(block):
        if isinstance(value, np.ndarray):
            given = path.rpartition(".")[2] in GIVEN
            read = (f"arrays[{place + 1 + axis}]" for axis in range(value.ndim))
            lengths = "".join(f"{one}, " for one in (read if given else value.shape))
            places[path] = f"array_at(arrays[{place}], ({lengths}))"
            place += 1 + value.ndim
        else:
            places[path] = leaf_text(f"numbers[{at(number)}]", path, value)
            number += 1
    return lambda path, _: places[path]


def leaf_text(text: str, path: str, value: Any) -> str:
    """The text of a double as the leaf at a path; what is part of the code is written out."""
    if not is_whole_kind(value):
        return text
    known = bool(value) if isinstance(value, bool | np.bool_) else int(value)
    return f"int({text})" if path.rpartition(".")[2] in GIVEN else repr(known)


def loader(block: Block, place: Place) -> FunctionType:
    """A function ``load(memory, lane)`` that returns a lane's state.

    ``place`` gives the index of the i-th number.
    """
    order = {path: i for i, (path, _) in enumerate(leaves(block))}
    return constructor("load(memory, lane)", block, lambda path, _: f"memory[{place(order[path])}]")


def storer(block: Block, place: Place = str) -> FunctionType:
    """A function ``store(memory, lane, s)`` that writes a state; ``place`` gives each index."""
    lines = [f"    memory[{place(i)}] = s.{path}" for i, (path, _) in enumerate(leaves(block))]
    return text_function("\n".join(["def store(memory, lane, s):", *lines, "    return None"]), {}, "store")


def recorder(paths: Sequence[str]) -> FunctionType:
    """A function ``record(out, row, s, m)`` that writes numbers of a state and of the monitors' as a row."""
    width = len(paths)
    lines = [f"    out[row * {width} + {column}] = {path}" for column, path in enumerate(paths)]
    return text_function("\n".join(["def record(out, row, s, m):", *lines, "    return None"]), {}, "record")


def checker(paths: Sequence[str], reach: Mapping[str, float]) -> FunctionType:
    """A function ``holds(s)`` that is true while the numbers at these paths of a state are all finite.

    0 x is 0 for a finite x and nan for others, and sums of 0 and nan tell which there were: that takes no
    branch, and pairs of pairs do not wait for each other.
    """

    def total(terms: Sequence[str]) -> str:
        half = len(terms) // 2
        return terms[0] if half == 0 else f"({total(terms[:half])} + {total(terms[half:])})"

    zero = total([f"0.0 * s.{path}" for path in paths] or ["0.0"])
    within = "".join(f" & (s.{path} >= -{end!r}) & (s.{path} <= {end!r})" for path, end in reach.items())
    return text_function(f"def holds(s): return ({zero} == 0.0){within}", {}, "holds")


def constructor(signature: str, block: Block, text: Text) -> FunctionType:
    """A function that makes a block of this shape from the text of each of its leaves."""
    namespace: dict[str, Any] = {"array_at": array_at}

    def call(part: Block, prefix: str) -> str:
        name = f"T{len(namespace)}"
        namespace[name] = type(part)
        arguments = (
            call(value, f"{prefix}{field}.") if is_block(value) else text(f"{prefix}{field}", value)
            for field, value in zip(part._fields, part, strict=True)
        )
        return f"{name}({', '.join(arguments)})"

    body = call(block, "")
    return text_function(f"def {signature}: return {body}", namespace, signature.partition("(")[0])


def text_function(text: str, namespace: dict[str, Any], name: str) -> FunctionType:
    """The function of that name in a text made from field names alone.

    The text is found where Python looks for that of files, as for any function.
    """
    file = f"<{name} {crc32(text.encode()):08x}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    namespace.setdefault("__name__", __name__)
    exec(compile(text, file, "exec"), namespace)
    function: FunctionType = namespace[name]
    return function
