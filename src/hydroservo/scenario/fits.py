"""Whether a class has what a role asks for."""

import inspect
from collections.abc import Sequence
from functools import cache
from types import FunctionType

from hydroservo import roles
from hydroservo.hooks import HOOKS

ROLES: tuple[type, ...] = tuple(
    value
    for name, value in vars(roles).items()
    if getattr(value, "_is_protocol", False) and name in roles.__all__
)


def said_roles(cls: type) -> tuple[type, ...]:
    """The roles that a class says it plays; none where it says nothing."""
    said = vars(cls).get("role", ()) if "role" not in getattr(cls, "_fields", ()) else ()
    several = said if isinstance(said, tuple) else (said,)
    for one in several:
        if one not in ROLES:
            name = getattr(one, "__name__", repr(one))
            raise ValueError(
                f"{cls.__name__} says that its role is {name}, which hydroservo.roles does not have"
            )
    return several


def roles_of(cls: type) -> tuple[type, ...]:
    """The roles that a class can play: those it says, or, where it says none, all whose methods it has."""
    return said_roles(cls) or tuple(role for role in ROLES if lacking(cls, role) is None)


def misfit(cls: type, role: type) -> str | None:
    """Why a class cannot take a role; None if it can.

    One that says its role has that alone; one that does not may take any role whose methods it has.
    """
    said = said_roles(cls)
    if said and role not in said:
        return f"it says that its role is {' and '.join(one.__name__ for one in said)}"
    return lacking(cls, role)


def check_said(cls: type) -> None:
    """Refuse a class that has not what the roles that it says ask for, or a hook that cannot be called."""
    for role in said_roles(cls):
        problem = lacking(cls, role) or wrong_hook(cls, role)
        if problem is not None:
            raise ValueError(f"{cls.__name__} says that its role is {role.__name__}: {problem}")


def a_role(role: type) -> str:
    """A role in a sentence, such as "an Observer"."""
    return f"{'an' if role.__name__[0] in 'AEIOU' else 'a'} {role.__name__}"


@cache
def lacking(cls: type, role: type) -> str | None:
    """Which method of a role a class has not, or not with as many arguments; None if it has all."""
    for name, wanted in role_methods(role).items():
        method = getattr(cls, name, None)
        if not isinstance(method, FunctionType):
            return f"it has no method {name}{shown(wanted)}"
        if not takes(method, len(wanted)):
            return f"its method {name} must be {name}{shown(wanted)}"
    return None


def wrong_hook(cls: type, role: type) -> str | None:
    """Which of the methods that a class may have besides takes other arguments than it is called with."""
    for hook in HOOKS:
        method = getattr(cls, hook.name, None)
        if hook.role in (None, role) and hook.arguments is not None and isinstance(method, FunctionType):
            wanted = ("self", *hook.arguments)
            if not takes(method, len(wanted)):
                return f"its method {hook.name} must be {hook.name}{shown(wanted)}"
    return None


@cache
def role_methods(role: type) -> dict[str, tuple[str, ...]]:
    """The methods of a role, with the names of their arguments, self among them."""
    return {
        name: tuple(inspect.signature(value).parameters)
        for name, value in vars(role).items()
        if isinstance(value, FunctionType) and not name.startswith("_")
    }


def shown(arguments: Sequence[str]) -> str:
    return f"({', '.join(arguments)})"


def takes(method: FunctionType, count: int) -> bool:
    """Whether a function can be called with so many arguments by position."""
    try:
        inspect.signature(method).bind(*[None] * count)
    except TypeError:
        return False
    return True
