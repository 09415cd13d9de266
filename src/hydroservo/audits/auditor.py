"""Asks a law, and each block in it, what it supposes of its loop."""

from collections.abc import Iterator
from typing import NamedTuple

from hydroservo.assumptions import Assumption, Facts
from hydroservo.block import Block, is_block
from hydroservo.controllers.saturation import Saturation
from hydroservo.plants.design_model import DesignModel


class Asked(NamedTuple):
    """A block of a law, and what it supposes.

    Attributes:
        path: of the block in the loop.
        block: its class.
        assumptions: what it supposes; None where it does not say.
    """

    path: str
    block: str
    assumptions: tuple[Assumption, ...] | None


def asked(law: Block, facts: Facts, path: str = "controller") -> Iterator[Asked]:
    """What a law supposes, and each block in it, the outermost first.

    Args:
        law: the law, designed.
        facts: of its loop.
        path: of the law in the loop.
    """
    own = tuple(law.assumptions(facts)) if hasattr(law, "assumptions") else None
    if own is not None or hasattr(law, "step"):
        yield Asked(path, type(law).__name__, own)
    inner = law.within(facts) if hasattr(law, "within") else facts
    for name, value in law._asdict().items():
        if is_block(value) and not isinstance(value, DesignModel | Saturation):
            yield from asked(value, inner, f"{path}.{name}")
