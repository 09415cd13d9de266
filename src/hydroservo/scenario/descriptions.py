"""What a scenario's types are, in words: those of a role, and the keys of one."""

import inspect
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from hydroservo.errors import ParameterError
from hydroservo.loop import Loop, Simulation
from hydroservo.nearest import nearest
from hydroservo.roles import Monitor
from hydroservo.scenario.catalogue import is_builtin
from hydroservo.scenario.declared import hints
from hydroservo.scenario.fits import ROLES, roles_of
from hydroservo.scenario.keys import Key, keys_of
from hydroservo.scenario.registry import Maker, known_classes, makers, makers_in_role

SETTINGS = "simulation"  # the table without types
ROLE_IN_TEXT = re.compile(r":\w+:`~?(?:[\w.]*\.)?([^`]*)`")


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
    tables = [role for role in hints(Loop).values() if role in ROLES]
    rest = [role for role in ROLES if role not in tables]
    found = {role.__name__: [*makers_in_role(role)] for role in (*tables, *rest)}
    return {name: types for name, types in found.items() if types}


def role_named(name: str) -> Mapping[str, Maker]:
    """The types of a role, or of a table of a scenario, by their names; none where it is neither."""
    role = Monitor if name.lower() == "metrics" else hints(Loop).get(name.lower())
    if role not in ROLES:
        role = next((one for one in ROLES if one.__name__.lower() == name.lower()), None)
    return {} if role is None else makers_in_role(role)


def descriptions(name: str) -> list[Description]:
    """The types of a name in words; there are several where blocks of different roles share it."""
    named = [(cls, maker) for cls in known_classes() if (maker := makers(cls).get(name)) is not None]
    if not named and name.lower() == SETTINGS:
        return [Description(SETTINGS, ["table"], plain(Simulation), keys_of(Simulation))]
    if not named:
        types = types_by_role()
        known = [SETTINGS, *types, *(name for names in types.values() for name in names)]
        shown = f"; `hydroservo scenarios show {name}` shows this one" if is_builtin(name) else ""
        problem = f"is not a type, role or table of a scenario{shown or nearest(name, known)}"
        raise ParameterError("name", name, problem)
    return [
        Description(name, [role.__name__ for role in roles_of(cls)], plain(maker), keys_of(maker))
        for cls, maker in named
    ]


def summary(maker: Maker) -> str:
    """The first sentence of what a type says of itself."""
    return plain(maker).partition("\n\n")[0].replace("\n", " ")


def plain(maker: Maker) -> str:
    """What a type says of itself, without marks of reStructuredText."""
    text = ROLE_IN_TEXT.sub(r"\1", inspect.cleandoc(maker.__doc__ or ""))
    return re.sub(r"::$", ":", text.replace("``", ""), flags=re.M)
