"""Blocks with random parameters whose nested blocks are any that play their role."""

from typing import get_type_hints

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from hydroservo.control.controlled import Velocity
from hydroservo.core.block import Block, replace
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import ControlledSignal, Start
from hydroservo.core.validation import consistent
from hydroservo.machine.starts import AsBuilt
from hydroservo.scenario.role_checks import ROLES
from hydroservo.testing.drawing import ParameterSpread, random_blocks
from hydroservo.testing.examples import example
from tests.support.roles import NOTHING, playing, wraps


def wired(cls: type, spread: ParameterSpread) -> SearchStrategy[Block]:
    """Blocks of a class, each nested block of any type that plays its role."""
    hints = get_type_hints(cls)
    inner = {
        name: st.one_of([wired(choice, spread) for choice in choices(cls, hints[name])])
        for name in cls._fields
        if hints[name] in ROLES
    }
    exchanged = st.fixed_dictionaries(inner)
    return st.builds(going_together, random_blocks(example(cls), spread), exchanged)


def going_together(block: Block, parts: dict[str, Block]) -> Block:
    """A block with these parts, or with numbers or parts of its example where those do not go together."""
    default = example(type(block))
    for candidate in (replace(block, parts), replace(default, parts)):
        try:
            consistent(candidate)
        except ParameterError:
            continue
        return candidate
    return default


def choices(cls: type, role: type) -> list[type]:
    """What may be nested in a block: a wrapper wraps no other here, and every signal is measured.

    Loops control the velocity, as the laws for it do, and start as they are built.
    """
    found = {ControlledSignal: [Velocity], Start: [AsBuilt]}.get(role) or playing(role)
    without = (*NOTHING, "OpenLoop")
    return [one for one in found if one.__name__ not in without and not (wraps(one) and cls in found)]
