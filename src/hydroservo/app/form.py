"""A loop as a form: a block for each block, a field with its unit for each number."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from hydroservo.app.source import Home, page_source
from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ParameterError, ScenarioError, clipped, defect, short
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.formatting import readable_unit
from hydroservo.core.group import group
from hydroservo.core.roles import ControlledSignal
from hydroservo.core.roles.saying import is_role
from hydroservo.core.validation import allowed
from hydroservo.scenario import Assembly
from hydroservo.scenario.build import SIGNALS, Context, Draft
from hydroservo.scenario.quantities import number_and_unit, unit_factor
from hydroservo.scenario.registry import makers, names_in_role
from hydroservo.scenario.role_checks import argument_types

MACHINE = ("load", "plant", "valve", "supply", "drive")
ORDER = ("reference", "controller", *MACHINE, "sensors", "hold", "simulation")
NO_FIELD = Field("", "")
LONGEST = 200  # characters of a path
OF_BLOCK = re.compile(r"(\w+) = (.*?): (.*)", re.DOTALL)  # what a block says of one of its numbers
NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
RANGE = re.compile(r"must be a finite number.*", re.DOTALL)
EXAMPLE = re.compile(r"such as '[^']*'")


def form_of(assembly: Assembly) -> list[dict[str, Any]]:
    """The blocks of a loop, each with its type, the types that it may have, its numbers and its blocks."""
    signal = assembly.loop.controls
    context = Context(controlled=signal.declared())
    controls = {
        "path": "controls",
        "type": type(signal).__name__,
        "types": types_of(ControlledSignal),
        "meaning": "the signal that the demand is of",
        "numbers": [],
        "blocks": [],
    }
    parts = (block_entry(name, assembly.drafts[name], argument_types(Loop)[name], context) for name in ORDER)
    return [controls, *parts]


def block_entry(path: str, draft: Draft, hint: Any, context: Context) -> dict[str, Any]:
    maker = draft.maker
    return {
        "path": path,
        "type": maker.__qualname__,
        "types": types_of(hint) if is_role(hint) else list(makers(made_class(maker))),
        "meaning": (made_class(maker).__doc__ or "").strip().partition("\n")[0],
        "numbers": list(number_entries(path, draft, context)),
        "blocks": list(block_entries(path, draft, context)),
    }


def made_class(maker: Any) -> type:
    found: type = maker if isinstance(maker, type) else maker.__self__
    return found


@cache
def types_of(role: type) -> list[str]:
    return names_in_role(role)


def block_entries(path: str, draft: Draft, context: Context) -> Iterator[dict[str, Any]]:
    signals = controlled_signals(draft)
    for name, one in draft.members.items():
        if isinstance(one, Draft):
            hint = argument_types(draft.maker).get(name)
            below = context if name in SIGNALS else context.below(signals, name)
            yield block_entry(f"{path}.{name}", one, hint, below)


def controlled_signals(draft: Draft) -> Any:
    """The signals that a block says it controls, as a group."""
    members = draft.members.items()
    return group({name: one.made() for name, one in members if name in SIGNALS and isinstance(one, Draft)})


def number_entries(path: str, draft: Draft, context: Context) -> Iterator[dict[str, Any]]:
    """The numbers of a block that may be given."""
    fields, kinds = declared_fields(draft.maker), argument_types(draft.maker)
    inside = context.below(controlled_signals(draft), "")
    for name, value in draft.members.items():
        kind = kinds.get(name)
        if kind not in (float, int, bool):
            continue
        field = fields.get(name, NO_FIELD).of(inside.controlled)
        if field.derived:
            continue
        given = draft.table.entry(name).value if draft.table.has(name) else None
        text = given if isinstance(given, str) else number_with_unit(value, field)
        yield {
            **number_entry(f"{path}.{name}", kind, field, text),
            "value": value if math.isfinite(value) else None,
            "low": finite_bound(field.at_least, field.above),
            "high": finite_bound(field.at_most, field.below),
        }


def number_entry(path: str, kind: Any, field: Field, text: str) -> dict[str, Any]:
    """What a page needs to have a number entered: its unit is the one of the text that stands there."""
    unit, factor = unit_and_factor(text, field) if kind is float else ("", 1.0)
    return {
        "path": path,
        "name": path.rpartition(".")[2],
        "kind": kind.__name__,
        "si": field.unit,
        "unit": unit,
        "factor": factor,
        "text": text,
        "meaning": field.meaning,
        "allowed": allowed(field_in_unit(field, unit, factor), kind is int),
    }


def unit_and_factor(text: str, field: Field) -> tuple[str, float]:
    """The unit of a text, else the one in which an engineer reads such a number, and the factor from SI."""
    try:
        unit = number_and_unit(text)[1].strip()
        return (unit, float(1 / unit_factor(unit, field.unit))) if unit else readable_unit_of(1.0, field)
    except ValueError:  # "auto", or no text
        return readable_unit_of(1.0, field)


def field_in_unit(field: Field, unit: str, factor: float) -> Field:
    """A declaration with its range in another unit."""
    ends = (field.above, field.at_least, field.below, field.at_most)
    above, at_least, below, at_most = (None if one is None else factor * one for one in ends)
    return replace(field, unit=unit, above=above, at_least=at_least, below=below, at_most=at_most)


def all_numbers(blocks: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    for block in blocks:
        yield from block["numbers"]
        yield from all_numbers(block["blocks"])


def finite_bound(*bounds: float | None) -> float | None:
    return next((one for one in bounds if one is not None and math.isfinite(one)), None)


def number_with_unit(value: float | int | bool, field: Field) -> str:
    """A number with its unit, as a scenario takes it."""
    if field.auto is not None and value == field.auto:
        return "auto"
    if isinstance(value, int):
        return str(value)
    unit, factor = readable_unit_of(value, field)
    return f"{value * factor:.10g} {unit}".strip()


def readable_unit_of(value: float, field: Field) -> tuple[str, float]:
    """The unit in which a number is read, and the factor from SI."""
    return readable_unit(field.unit, abs(value) if math.isfinite(value) else 0.0)


class Stopped(Exception):  # noqa: N818, for it is no error
    """The page asked for an end."""


def failure_on_page(error: Exception) -> dict[str, Any]:
    """An error as a page shows it: the dotted path of a field, "" for none, and what is wrong."""
    if isinstance(error, ScenarioError):
        path, said = clipped(error.key, LONGEST), OF_BLOCK.fullmatch(error.problem)
        if path and said:
            return {"path": f"{path}.{said[1]}", "problem": f"{said[2]}: {said[3]}"}
        return {"path": path, "problem": error.problem}
    if isinstance(error, ParameterError):
        return {"path": error.path, "problem": f"{short(error.value)}: {error.allowed}"}
    if isinstance(error, HydroservoError):
        return {"path": "", "problem": str(error)}
    return {"path": "", "problem": defect(error)}


def failure_at_field(error: Exception, request: Mapping[str, Any], home: Home) -> dict[str, Any]:
    """An error as :func:`failure_on_page` has it, in the unit of the field at which it is shown."""
    found, before = failure_on_page(error), request.get("before")
    asked = "given" in request  # for numbers that are no fields yet
    if asked or not found["path"] or not isinstance(before, Mapping):
        return found
    try:
        form = form_of(page_source({**request, "changes": before}, home).assemble())
    except HydroservoError:
        return found
    entry = next((one for one in all_numbers(form) if one["path"] == found["path"]), None)
    if entry is None:
        return found
    text = request.get("changes", {}).get(found["path"], entry["text"])
    return {**found, "problem": problem_in_own_unit(found["problem"], str(text), entry)}


def problem_in_own_unit(problem: str, text: str, entry: Mapping[str, Any]) -> str:
    """What is wrong with a number, in the unit in which a page shows it."""
    unit, si, text = entry["unit"], entry["si"], text.strip()
    if unit and re.fullmatch(NUMBER, text):
        return f"{text} has no unit: {text} {unit}?"
    example = f"such as '{entry['text'] or f'1.5 {unit}'}'"
    said = EXAMPLE.sub(lambda _: example, RANGE.sub(f"must be {entry['allowed']}", problem))
    value = re.match(f"{NUMBER}: ", said)
    head, tail = (f"{text}: ", said[value.end() :]) if value else ("", said)
    if not si or unit == si:
        return head + tail
    tail = tail.replace(f"does not convert to {si}", f"does not convert to {unit}")
    written = re.compile(rf"({NUMBER}) (?:\[{re.escape(si)}\]|{re.escape(si)}(?![\w^²³/]))")
    return head + written.sub(lambda one: f"{entry['factor'] * float(one[1]):.6g} {unit}", tail)
