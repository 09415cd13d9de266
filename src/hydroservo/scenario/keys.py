"""The keys that a table of a scenario may have: those of the block that its ``type`` names."""

import inspect
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from hydroservo.block import is_block
from hydroservo.curve import Curve
from hydroservo.field import CONTROLLED, Field, declared_fields
from hydroservo.roles.saying import is_role
from hydroservo.scenario.declared import hints
from hydroservo.scenario.plugins import is_block_class
from hydroservo.scenario.registry import Maker

ANY_SIGNAL = Field(CONTROLLED, "controlled signal")


class Key(NamedTuple):
    """A key of a table.

    Attributes:
        name: as it is written.
        kind: float, int or bool, Curve, a role, or a class of blocks.
        default: what holds without it; None if it must be there.
        field: the declaration of a number; None of a nested block that declares none.
    """

    name: str
    kind: Any
    default: Any
    field: Field | None

    @property
    def nests(self) -> bool:
        """Whether it is a table of a block."""
        return self.kind is not Curve and (
            is_role(self.kind) or is_block_class(self.kind) or is_block(self.default)
        )

    @property
    def shown(self) -> str:
        """The default as a scenario has it; empty where there is none."""
        if self.kind is Curve:
            return "straight" if self.default is not None and self.default.coefficients.any() else ""
        if is_block(self.default):
            return type(self.default).__name__
        if isinstance(self.default, bool):
            return str(self.default).lower()
        if isinstance(self.default, np.ndarray):
            return "from a file"
        if not isinstance(self.default, int | float):
            return ""
        automatic = self.field is not None and self.default == self.field.auto
        return '"auto"' if automatic else f"{self.default:g}"

    @property
    def meaning(self) -> str:
        """What it is for; of a table, what block that must be."""
        if self.nests:
            return f"a table: {getattr(self.kind, '__name__', 'a block')}"
        return self.field.of(ANY_SIGNAL).meaning if self.field else ""

    def as_dict(self) -> dict[str, str]:
        """All of it in words."""
        field = Field("", "") if self.nests or self.field is None else self.field.of(ANY_SIGNAL)
        return {
            "name": self.name,
            "default": self.shown,
            "unit": f"{field.unit or 1} over {field.over or 1}" if self.kind is Curve else field.unit,
            "range": range_of(field),
            "meaning": self.meaning,
            "source": field.source,
        }


def keys_of(maker: Maker) -> list[Key]:
    """The keys of a table whose ``type`` names a block's class, or a constructor of one, in their order."""
    kinds, fields = hints(maker), declared_fields(maker)
    return [
        Key(name, kinds.get(name), default, fields.get(name)) for name, default in defaults(maker).items()
    ]


@cache
def defaults(maker: Maker) -> Mapping[str, Any]:
    """The default of each argument, in order; None where there is none."""
    names = [*inspect.signature(maker).parameters]
    if is_block_class(maker):
        known = maker._field_defaults  # type: ignore[attr-defined]
    else:
        values = maker.__defaults__ or ()
        known = dict(zip(names[len(names) - len(values) :], values, strict=True))
    return {name: known.get(name) for name in names}


def range_of(field: Field) -> str:
    """The range of a number, such as ``> 0, ≤ 1``; empty where it may be any."""
    limits = ((">", field.above), ("≥", field.at_least), ("<", field.below), ("≤", field.at_most))
    found = [f"{sign} {limit:g}" for sign, limit in limits if limit is not None]
    return ", ".join(found if field.auto is None else [*found, 'or "auto"'])
