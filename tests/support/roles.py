"""Which blocks hydroservo has, and in which roles."""

from functools import cache
from typing import get_type_hints

from hydroservo.papers.tsmc_eha_2021 import printed
from hydroservo.scenario.registry import is_block_class, shipped_classes
from hydroservo.scenario.role_checks import declared_roles

NOTHING = ("NoEdges", "NoForce", "NoPosition", "NoPressure", "NoValve")  # whose answer is that there is none


def role_of(cls: type) -> type:
    """The one role that a block says."""
    (said,) = declared_roles(cls)
    return said


def blocks() -> list[type]:
    """Every block class that the packages of devices and laws export, and a paper's laws as printed."""
    own = (value for value in vars(printed).values() if is_block_class(value))
    as_printed = [cls for cls in own if cls.__module__ == printed.__name__]
    return [cls for cls in (*shipped_classes(), *as_printed) if declared_roles(cls)]


def identifier(cls: type) -> str:
    """Such as loads.Sine."""
    return f"{cls.__module__.split('.')[1]}.{cls.__name__}"


@cache
def playing(role: type) -> list[type]:
    """The block classes of a role."""
    return [cls for cls in blocks() if role in declared_roles(cls)]


def wraps(cls: type) -> bool:
    """True for a block that nests another of its own role."""
    return role_of(cls) in get_type_hints(cls).values()
