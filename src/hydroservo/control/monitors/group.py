"""Which monitors a loop has, and what they are called."""

from collections.abc import Mapping
from keyword import iskeyword
from typing import NamedTuple

from hydroservo.core.block import Block, is_block
from hydroservo.core.errors import ParameterError


class Usual(NamedTuple):
    """The monitors that a loop usually has."""


def named(metrics: object) -> dict[str, Block]:
    """Monitors by name, from a mapping, or from a sequence that has none: each is called after its class.

    Raises:
        ParameterError: what is given is neither, or something in it is no monitor.
    """
    if is_block(metrics) or not isinstance(metrics, Mapping | list | tuple):
        raise ParameterError("metrics", metrics, "must be a list of monitors, or map names to them")
    found = dict(metrics) if isinstance(metrics, Mapping) else by_class(metrics)
    for name, one in found.items():
        if isinstance(one, Usual):
            continue
        if not (is_block(one) and all(hasattr(one, method) for method in ("init", "step", "values"))):
            raise ParameterError(
                f"metrics.{name}", one, "must be a monitor: a block with init, step and values"
            )
        if not (isinstance(name, str) and is_name(name)):
            raise ParameterError("metrics", name, "must be a name of letters, digits and underscores")
    return found


def is_name(text: str) -> bool:
    """Whether a monitor can be called so: as a field of a block."""
    return text.isidentifier() and text[0] != "_" and not iskeyword(text)


def by_class(monitors: list[Block] | tuple[Block, ...]) -> dict[str, Block]:
    """Monitors by the names of their classes in lower case; those of one class are numbered."""
    found: dict[str, Block] = {}
    for one in monitors:
        name = snake_case(type(one).__name__)
        alike = sum(other == name or other.startswith(f"{name}_") for other in found)
        found[f"{name}_{alike + 1}" if alike else name] = one
    return found


def snake_case(name: str) -> str:
    """``ChamberPressures`` as ``chamber_pressures``."""
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")
