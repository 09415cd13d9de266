"""The keys that a table of a scenario may have, and what its types are, in words."""

import inspect
import re
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from hydroservo.control.loop import Loop, Simulation
from hydroservo.core.block import is_block
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import CONTROLLED, Field, declared_fields
from hydroservo.core.nearest import nearest
from hydroservo.core.roles import Monitor
from hydroservo.core.roles.saying import is_role
from hydroservo.scenario.fits import ROLES, argument_types, possible_roles
from hydroservo.scenario.layers import is_builtin
from hydroservo.scenario.plugins import is_block_class
from hydroservo.scenario.registry import Maker, known_classes, makers, makers_in_role

ANY_SIGNAL = Field(CONTROLLED, "controlled signal")
SETTINGS = "simulation"  # the table without types
ROLE_IN_TEXT = re.compile(r":\w+:`~?(?:[\w.]*\.)?([^`]*)`")


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
            "range": range_text(field),
            "meaning": self.meaning,
            "source": field.source,
        }


def keys_of(maker: Maker) -> list[Key]:
    """The keys of a table whose ``type`` names a block's class, or a constructor of one, in their order."""
    kinds, fields = argument_types(maker), declared_fields(maker)
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


def range_text(field: Field) -> str:
    """The range of a number, such as ``> 0, ≤ 1``; empty where it may be any."""
    limits = ((">", field.above), ("≥", field.at_least), ("<", field.below), ("≤", field.at_most))
    found = [f"{sign} {limit:g}" for sign, limit in limits if limit is not None]
    return ", ".join(found if field.auto is None else [*found, 'or "auto"'])


class Description(NamedTuple):
    """A type in words.

    Attributes:
        name: as ``type`` gives it.
        roles: that its class can play.
        text: what it is, its equation, its source and where it fails.
        keys: of its table.
    """

    name: str
    roles: list[str]
    text: str
    keys: list[Key]

    def as_dict(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {**self._asdict(), "keys": [key.as_dict() for key in self.keys]}


def types_by_role() -> dict[str, list[str]]:
    """The types of each role that has some, those of a scenario's tables first."""
    tables = [role for role in argument_types(Loop).values() if role in ROLES]
    rest = [role for role in ROLES if role not in tables]
    found = {role.__name__: [*makers_in_role(role)] for role in (*tables, *rest)}
    return {name: types for name, types in found.items() if types}


def role_named(name: str) -> Mapping[str, Maker]:
    """The types of a role, or of a table of a scenario, by their names; none where it is neither."""
    role = Monitor if name.lower() == "metrics" else argument_types(Loop).get(name.lower())
    if role not in ROLES:
        role = next((one for one in ROLES if one.__name__.lower() == name.lower()), None)
    return {} if role is None else makers_in_role(role)


def describe_types(name: str) -> list[Description]:
    """The types of a name in words; there are several where blocks of different roles share it."""
    named = [(cls, maker) for cls in known_classes() if (maker := makers(cls).get(name)) is not None]
    if not named and name.lower() == SETTINGS:
        return [Description(SETTINGS, ["table"], docstring_text(Simulation), keys_of(Simulation))]
    if not named:
        types = types_by_role()
        known = [SETTINGS, *types, *(name for names in types.values() for name in names)]
        shown = f"; `hydroservo scenarios show {name}` shows this one" if is_builtin(name) else ""
        problem = f"is not a type, role or table of a scenario{shown or nearest(name, known)}"
        raise ParameterError("name", name, problem)
    return [
        Description(
            name, [role.__name__ for role in possible_roles(cls)], docstring_text(maker), keys_of(maker)
        )
        for cls, maker in named
    ]


def first_sentence(maker: Maker) -> str:
    """The first sentence of what a type says of itself."""
    return docstring_text(maker).partition("\n\n")[0].replace("\n", " ")


def docstring_text(maker: Maker) -> str:
    """What a type says of itself, without marks of reStructuredText."""
    text = ROLE_IN_TEXT.sub(r"\1", inspect.cleandoc(maker.__doc__ or ""))
    return re.sub(r"::$", ":", text.replace("``", ""), flags=re.M)
