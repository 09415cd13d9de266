"""A loop as a form: a block for each block, a field with its unit for each number."""

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

from hydroservo.field import Field, declared_fields
from hydroservo.formatting import readable_unit
from hydroservo.group import group
from hydroservo.loop import Loop
from hydroservo.roles import ControlledSignal
from hydroservo.roles.saying import is_role
from hydroservo.scenario import Assembly
from hydroservo.scenario.build import SIGNALS, Context, Draft
from hydroservo.scenario.declared import hints
from hydroservo.scenario.registry import makers, names_in_role

__all__ = ["form_of", "shown"]

MACHINE = ("load", "plant", "valve", "supply", "drive")
ORDER = ("reference", "controller", *MACHINE, "sensors", "hold", "simulation")
NO_FIELD = Field("", "")


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
    parts = (block_of(name, assembly.drafts[name], hints(Loop)[name], context) for name in ORDER)
    return [controls, *parts]


def block_of(path: str, draft: Draft, hint: Any, context: Context) -> dict[str, Any]:
    """A block, and those in it."""
    maker = draft.maker
    return {
        "path": path,
        "type": maker.__qualname__,
        "types": types_of(hint) if is_role(hint) else list(makers(class_of(maker))),
        "meaning": first_line(class_of(maker)),
        "numbers": list(numbers_of(path, draft, context)),
        "blocks": list(blocks_of(path, draft, context)),
    }


def class_of(maker: Any) -> type:
    found: type = maker if isinstance(maker, type) else maker.__self__
    return found


def first_line(cls: type) -> str:
    """What a class says that it is."""
    return (cls.__doc__ or "").strip().partition("\n")[0]


@cache
def types_of(role: type) -> list[str]:
    return names_in_role(role)


def blocks_of(path: str, draft: Draft, context: Context) -> Iterator[dict[str, Any]]:
    signals = signals_of(draft)
    for name, one in draft.members.items():
        if isinstance(one, Draft):
            hint = hints(draft.maker).get(name)
            below = context if name in SIGNALS else context.below(signals, name)
            yield block_of(f"{path}.{name}", one, hint, below)


def signals_of(draft: Draft) -> Any:
    """The signals that a block says it controls, as a group."""
    members = draft.members.items()
    return group({name: one.made() for name, one in members if name in SIGNALS and isinstance(one, Draft)})


def numbers_of(path: str, draft: Draft, context: Context) -> Iterator[dict[str, Any]]:
    """The numbers of a block that may be given."""
    fields, kinds = declared_fields(draft.maker), hints(draft.maker)
    inside = context.below(signals_of(draft), "")
    for name, value in draft.members.items():
        kind = kinds.get(name)
        if kind not in (float, int, bool):
            continue
        field = fields.get(name, NO_FIELD).of(inside.controlled)
        if field.derived:
            continue
        given = draft.table.entry(name).value if draft.table.has(name) else None
        unit, factor = unit_of(value, field)
        yield {
            "path": f"{path}.{name}",
            "name": name,
            "kind": kind.__name__,
            "unit": unit if kind is float else "",
            "factor": factor if kind is float else 1.0,
            "value": value if math.isfinite(value) else None,
            "text": given if isinstance(given, str) else shown(value, field),
            "meaning": field.meaning,
            "low": bound(field.at_least, field.above),
            "high": bound(field.at_most, field.below),
        }


def bound(*bounds: float | None) -> float | None:
    """The bound of a range that is there."""
    return next((one for one in bounds if one is not None and math.isfinite(one)), None)


def shown(value: float | int | bool, field: Field) -> str:
    """A number with its unit, as a scenario takes it."""
    if field.auto is not None and value == field.auto:
        return "auto"
    if isinstance(value, int):
        return str(value)
    unit, factor = unit_of(value, field)
    return f"{value * factor:.10g} {unit}".strip()


def unit_of(value: float, field: Field) -> tuple[str, float]:
    """The unit in which a number is read, and the factor from SI."""
    return readable_unit(field.unit, abs(value) if math.isfinite(value) else 0.0)
