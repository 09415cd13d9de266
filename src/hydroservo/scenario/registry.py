"""Which block classes a scenario may name, and in which role."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from hydroservo.control import controlled, controllers, error_dynamics, holds, monitors, observers, references
from hydroservo.core.nearest import nearest, one_of
from hydroservo.machine import (
    drives,
    integrators,
    loads,
    mechanics,
    oils,
    plants,
    sensors,
    starts,
    supplies,
    valves,
)
from hydroservo.scenario.fits import a_role, role_problem
from hydroservo.scenario.plugins import is_block_class, plugin_classes, plugin_other_classes
from hydroservo.scenario.tables import TableEntry

Maker = Callable[..., Any]  # a block's class, or a classmethod of it whose arguments are declared as fields

OWN = "a class of your own needs its file: --plugin FILE, in Python plugins=[FILE]"

PACKAGES = (
    controlled,
    controllers,
    drives,
    error_dynamics,
    holds,
    integrators,
    loads,
    mechanics,
    monitors,
    observers,
    oils,
    plants,
    references,
    sensors,
    starts,
    supplies,
    valves,
)


@cache
def makers(cls: type) -> dict[str, Maker]:
    """What makes blocks of a class, by the name that ``type`` gives it: the class, and its constructors."""
    constructors = (
        name for name, value in vars(cls).items() if isinstance(value, classmethod) and name[0] != "_"
    )
    return {cls.__name__: cls} | {f"{cls.__name__}.{name}": getattr(cls, name) for name in constructors}


def maker_in_role(role: type, entry: TableEntry) -> Maker:
    """What a ``type`` names, among what makes blocks of a role."""
    wanted = entry.value if isinstance(entry.value, str) else ""
    named = [*shipped_makers().get(wanted, ()), *(cls for cls in plugin_classes() if wanted in makers(cls))]
    fitting = [cls for cls in named if role_problem(cls, role) is None]
    if len(fitting) > 1:
        places = " and ".join(cls.__module__ for cls in fitting)
        raise entry.error(f"names two classes, of {places}; rename that of the plugin")
    if fitting:
        return makers(fitting[0])[wanted]
    if named:
        raise entry.error(f"cannot be {a_role(role)}: {role_problem(named[0], role)}")
    raise entry.error(no_type(wanted, names_in_role(role)))


def no_type(wanted: str, names: Sequence[str]) -> str:
    """What is wrong with a name that no type has, and what it may be meant for; then all names there are."""
    if not wanted:
        return one_of(wanted, names)
    if wanted in plugin_other_classes():
        mend = f"; the plugin's class {wanted} is not a NamedTuple; write class {wanted}(NamedTuple):"
    else:
        mend = f"{nearest(wanted, names)}; {OWN}"
    return f"is not a type here{mend}; it must be one of {', '.join(names)}"


def names_in_role(role: type) -> list[str]:
    """The names that ``type`` may have in a role."""
    return [*makers_in_role(role)]


def makers_in_role(role: type) -> dict[str, Maker]:
    """What makes blocks of a role, by the names that ``type`` may have, in their order."""
    fitting = (cls for cls in known_classes() if role_problem(cls, role) is None)
    found = {name: maker for cls in fitting for name, maker in makers(cls).items()}
    return {name: found[name] for name in sorted(found)}


def known_classes() -> tuple[type, ...]:
    return (*shipped_classes(), *plugin_classes())


@cache
def shipped_makers() -> dict[str, list[type]]:
    """The shipped classes that a name makes blocks of."""
    found: dict[str, list[type]] = {}
    for cls in shipped_classes():
        for name in makers(cls):
            found.setdefault(name, []).append(cls)
    return found


@cache
def shipped_classes() -> tuple[type, ...]:
    """The classes of blocks and states that hydroservo has."""
    exported = (getattr(package, name) for package in PACKAGES for name in package.__all__)
    return tuple(value for value in exported if is_block_class(value))
