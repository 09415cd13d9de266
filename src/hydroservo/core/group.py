"""Blocks and numbers under names of their own, as one block."""

import copyreg
from collections import namedtuple
from collections.abc import Mapping
from functools import cache
from typing import Any

from hydroservo.core.block import Block


def group(members: Mapping[str, Any]) -> Block:
    """Blocks or numbers as one block, whose fields are their names."""
    return group_class(tuple(members))(*members.values())


def nested(numbers: Mapping[str, float]) -> Block:
    """Numbers by dotted path as groups in groups.

    Args:
        numbers: such as ``{"plant.velocity": 0.1, "valve.opening": 1e-4}``.
    """
    heads = dict.fromkeys(path.partition(".")[0] for path in numbers)
    members: dict[str, Any] = {}
    for head in heads:
        inner = {
            path.removeprefix(f"{head}."): one for path, one in numbers.items() if path.startswith(f"{head}.")
        }
        members[head] = nested(inner) if inner else numbers[head]
    return group(members)


@cache
def group_class(names: tuple[str, ...]) -> type[Any]:
    """A block with fields of these names; it pickles by what makes it, for it stands in no module."""
    made: Any = namedtuple("Group", list(names))  # type: ignore[misc]
    copyreg.pickle(made, pickled)
    found: type[Any] = made
    return found


def pickled(members: Any) -> tuple[Any, ...]:
    """What pickle keeps of a group: how to make it again."""
    return group, (members._asdict(),)
