"""Numbers in memory and in tuples, by their index."""

import ast
from typing import Any

from hydroservo.engine.lower import numbers
from hydroservo.engine.lower.values import (
    ADDRESS,
    BOOL,
    DOUBLE,
    INTEGER,
    Array,
    LoweringError,
    Pointer,
    Record,
    Scalar,
    kind_of,
    operand,
)
from hydroservo.engine.lower.writer import Writer, said


def loaded(w: Writer, kind: str, address: str, index: Any) -> Scalar:
    """The number at an index from an address on."""
    return w.emit(kind, f"load {kind}, ptr {located(w, kind, address, index)}, align 8")


def stored(w: Writer, kind: str, address: str, index: Any, value: Any) -> None:
    """Writes a number at an index from an address on."""
    given = operand(w.converted(value, kind))
    w.line(f"store {kind} {given}, ptr {located(w, kind, address, index)}, align 8")


def located(w: Writer, kind: str, address: str, index: Any) -> str:
    return w.emit(ADDRESS, f"getelementptr {kind}, ptr {address}, i64 {operand(index)}").text


def item(w: Writer, owner: Any, index: Any) -> Any:
    """What stands at an index."""
    if isinstance(owner, Pointer):
        return loaded(w, owner.element, owner.text, whole_index(w, index))
    if isinstance(owner, Array):
        place, rest = inside(w, owner, index)
        if rest:
            start = w.emit(ADDRESS, f"getelementptr double, ptr {owner.parts[0].text}, i64 {operand(place)}")
            return Array([start, *rest])
        return loaded(w, DOUBLE, owner.parts[0].text, place)
    if isinstance(owner, Record):
        return part_at(w, owner, index)
    raise LoweringError(f"compiled code cannot index {said(owner)}")


def put(w: Writer, owner: Any, index: Any, value: Any) -> None:
    """Writes a number at an index."""
    if isinstance(owner, Pointer):
        stored(w, owner.element, owner.text, whole_index(w, index), value)
        return
    if not isinstance(owner, Array):
        raise LoweringError(f"compiled code cannot change {said(owner)}")
    place, rest = inside(w, owner, index)
    if rest:
        raise LoweringError("compiled code writes one number of an array at a time")
    stored(w, DOUBLE, owner.parts[0].text, place, value)


def whole_index(w: Writer, index: Any) -> Any:
    """An index as a whole number."""
    if isinstance(index, Record | Array | Pointer) or index is None or kind_of(index) == DOUBLE:
        raise LoweringError(f"{said(index)} is not an index")
    return w.converted(index, INTEGER)


def inside(w: Writer, array: Array, index: Any) -> tuple[Any, tuple[Any, ...]]:
    """The place that indices give in an array, and the lengths of what is there; raises beyond its ends."""
    indices = index.parts if isinstance(index, Record) else (index,)
    if len(indices) > len(array.lengths):
        raise LoweringError(f"{len(indices)} indices are too many for an array of {len(array.lengths)} axes")
    place: Any = 0
    for axis, length in enumerate(array.lengths):
        place = numbers.binary(w, ast.Mult, place, length)
        if axis < len(indices):
            place = numbers.binary(w, ast.Add, place, counted(w, indices[axis], length))
    return place, array.lengths[len(indices) :]


def counted(w: Writer, index: Any, length: Any) -> Any:
    """An index counted from the front; an exception if there is no such place."""
    i = whole_index(w, index)
    if isinstance(i, Scalar):
        back = numbers.binary(w, ast.Add, i, length)
        i = w.selected(w.emit(BOOL, f"icmp slt i64 {i.text}, 0"), back, i)
    elif i < 0:
        i = numbers.binary(w, ast.Add, i, length)
    w.require(w.emit(BOOL, f"icmp ult i64 {operand(i)}, {operand(length)}"))
    return i


def part_at(w: Writer, record: Record, index: Any) -> Any:
    """The part of a tuple at an index, which need not be known if its parts are alike."""
    i, parts = whole_index(w, index), record.parts
    if not isinstance(i, Scalar):
        if not -len(parts) <= i < len(parts):
            raise LoweringError(f"{said(record)} has no place {i}")
        return parts[i]
    i = counted(w, i, len(parts))
    found = parts[-1]
    for number, part in enumerate(parts[:-1]):
        found = w.selected(w.emit(BOOL, f"icmp eq i64 {operand(i)}, {number}"), part, found)
    return found
