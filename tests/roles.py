"""Which blocks there are, and what each role promises."""

import inspect
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from types import FunctionType
from typing import Any, get_type_hints

from hydroservo.scenario.fits import said_roles

PACKAGES = (
    "controllers",
    "observers",
    "references",
    "holds",
    "loads",
    "mechanics",
    "oils",
    "valves",
    "supplies",
    "sensors",
    "plants",
    "papers.tsmc_eha_2021.printed",
)
PLAIN = {"designed", "missing", "simplified"}  # methods that only Python calls
NOTHING = ("NoPosition", "NoPressure")  # blocks whose answer, nan, is that there is none


def methods(cls: type) -> Mapping[str, tuple[str, ...]]:
    """The public methods of a block class or role, with the names of their arguments."""
    found = {name: f for name, f in vars(cls).items() if isinstance(f, FunctionType) and name[0] != "_"}
    return {
        name: tuple(inspect.signature(f).parameters)[1:] for name, f in found.items() if name not in PLAIN
    }


def role_of(cls: type) -> type:
    """The one role that a block says.

    Raises:
        LookupError: it says none, or more than one.
    """
    said = said_roles(cls)
    if len(said) != 1:
        raise LookupError(f"{cls.__module__}.{cls.__name__} says {len(said)} roles: say @role(...) above it")
    return said[0]


def blocks() -> list[type]:
    """Every block class that the packages of devices and laws export; a class without methods is a state."""
    exported = [
        getattr(package, name)
        for package in (import_module(f"hydroservo.{name}") for name in PACKAGES)
        for name in package.__all__
    ]
    return [cls for cls in exported if hasattr(cls, "_fields") and methods(cls)]


def identifier(cls: type) -> str:
    """Such as loads.Sine."""
    return f"{cls.__module__.split('.')[1]}.{cls.__name__}"


@cache
def playing(role: Any) -> list[type]:
    """The block classes of a role."""
    return [cls for cls in blocks() if role_of(cls) is role]


def wraps(cls: type) -> bool:
    """True for a block that nests another of its own role."""
    return role_of(cls) in get_type_hints(cls).values()
