"""Which block classes a scenario may name, and in which role."""

import inspect
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

from hydroservo import (
    controllers,
    holds,
    integrators,
    loads,
    mechanics,
    observers,
    oils,
    plants,
    references,
    sensors,
    supplies,
    valves,
)
from hydroservo.nearest import one_of
from hydroservo.scenario.plugins import is_block_class, plugin_classes
from hydroservo.scenario.tables import Entry

__all__ = ["Maker", "maker_in_role", "makers", "misfit", "names_in_role"]

Maker = Callable[..., Any]  # a block's class, or a classmethod of it whose arguments are declared as fields

PACKAGES = (
    controllers,
    holds,
    integrators,
    loads,
    mechanics,
    observers,
    oils,
    plants,
    references,
    sensors,
    supplies,
    valves,
)


def makers(cls: type) -> dict[str, Maker]:
    """What makes blocks of a class, by the name that ``type`` gives it: the class, and its constructors."""
    constructors = (
        name for name, value in vars(cls).items() if isinstance(value, classmethod) and name[0] != "_"
    )
    return {cls.__name__: cls} | {f"{cls.__name__}.{name}": getattr(cls, name) for name in constructors}


def maker_in_role(role: type, entry: Entry) -> Maker:
    """What a ``type`` names, among what makes blocks that have the methods of a role.

    Raises:
        ScenarioError: there is none, or more than one.
    """
    wanted = entry.value if isinstance(entry.value, str) else ""
    named = [cls for cls in known_classes() if wanted in makers(cls)]
    fitting = [cls for cls in named if misfit(cls, role) is None]
    if len(fitting) > 1:
        places = " and ".join(cls.__module__ for cls in fitting)
        raise entry.error(f"names two classes, of {places}; rename that of the plugin")
    if fitting:
        return makers(fitting[0])[wanted]
    if named:
        raise entry.error(f"cannot be a {role.__name__}: {misfit(named[0], role)}")
    raise entry.error(one_of(wanted, names_in_role(role)))


def names_in_role(role: type) -> list[str]:
    """The names that ``type`` may have in a role."""
    return sorted({name for cls in known_classes() if misfit(cls, role) is None for name in makers(cls)})


def misfit(cls: type, role: type) -> str | None:
    """Why a class cannot take a role; None if it can.

    hydroservo's own blocks name their arguments as the role does, and those names tell roles with methods
    of the same name apart; a plugin's methods need only take as many.
    """
    own = cls in shipped_classes()
    for name, wanted in role_methods(role).items():
        method = getattr(cls, name, None)
        if not isinstance(method, FunctionType):
            return f"it has no method {name}{wanted}"
        arguments = inspect.signature(method)
        if not takes(arguments, len(wanted.parameters)) or (
            own and [*arguments.parameters] != [*wanted.parameters]
        ):
            return f"its method {name} must be {name}{wanted}"
    return None


def known_classes() -> tuple[type, ...]:
    return (*shipped_classes(), *plugin_classes())


@cache
def shipped_classes() -> tuple[type, ...]:
    exported = (getattr(package, name) for package in PACKAGES for name in package.__all__)
    return tuple(value for value in exported if is_block_class(value))


@cache
def role_methods(role: type) -> dict[str, inspect.Signature]:
    methods = {name: value for name, value in vars(role).items() if isinstance(value, FunctionType)}
    return {name: bare(inspect.signature(m)) for name, m in methods.items() if not name.startswith("_")}


def bare(signature: inspect.Signature) -> inspect.Signature:
    """A signature without annotations, as a message shows it."""
    parameters = [p.replace(annotation=inspect.Parameter.empty) for p in signature.parameters.values()]
    return inspect.Signature(parameters)


def takes(signature: inspect.Signature, count: int) -> bool:
    try:
        signature.bind(*[None] * count)
    except TypeError:
        return False
    return True
