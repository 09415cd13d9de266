"""What is asked of: a block in a role, and what is said where it is not as it must be."""

import math
import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hydroservo.control.controlled import Velocity
from hydroservo.control.wiring import with_model, with_signal
from hydroservo.core.block import Block, is_block, leaves
from hydroservo.core.roles import Monitor
from hydroservo.machine.plants import DesignModel
from hydroservo.scenario.role_checks import (
    class_line,
    declared_roles,
    possible_roles,
    role_methods,
    source_file,
)
from hydroservo.testing.examples import EXAMPLES, example

PLAIN = {"declared", "simplified", "substeps_for", "trusted_rate"}  # methods of roles that only Python calls
NAMED = re.compile(r"^(?P<file>.+?), line (?P<line>\d+), ")  # how translation names a place
CANONICAL_NAN = struct.pack("<d", float("nan"))


class ContractError(AssertionError):
    """A block is not what a block must be.

    Attributes:
        line: of the block's file, 0 where that is not known.
    """

    def __init__(self, problem: str, line: int = 0) -> None:
        self.line = line
        super().__init__(problem)


@dataclass(frozen=True, eq=False)
class Case:
    """A block, and the role in which it is asked."""

    block: Block
    role: type

    @property
    def cls(self) -> type:
        """The block's class."""
        return type(self.block)

    @property
    def has_state(self) -> bool:
        """Whether blocks of the role have a state."""
        return "init" in role_methods(self.role)

    def compiled_methods(self) -> list[str]:
        """The methods of the role that compiled code calls."""
        if self.role is Monitor:
            return ["step"]
        return [name for name in role_methods(self.role) if name not in PLAIN]

    def error(self, problem: str, member: str = "", places: Sequence[tuple[str, int]] = ()) -> ContractError:
        """What is wrong, at the line that the text names, or else of a field or method, or of the class."""
        named = NAMED.search(problem)
        if named is not None:
            places = [(named["file"], int(named["line"]))]
        own = Path(source_file(self.cls)).name
        line = next((line for file, line in places if Path(file).name == own), None)
        if line is None:
            return ContractError(problem, class_line(self.cls, member))
        return ContractError(NAMED.sub("", problem, count=1), line)


def case_of(block: Any, role: type | None = None) -> Case:
    """A block to be asked, by itself or by its class, whose defaults it then has.

    A law that believes in the machine of its loop is asked with an example of a design model, and one that
    controls what its loop does with the velocity.
    """
    cls = block if isinstance(block, type) else type(block)
    asked = example_of(block) if isinstance(block, type) else block
    filled = with_signal(with_model(asked, example(DesignModel)), Velocity())
    return Case(filled, role or only_role(cls))


def only_role(cls: type) -> type:
    """The role that a class says, or the only one whose methods it has."""
    try:
        roles = possible_roles(cls)
    except ValueError as error:
        raise ContractError(str(error), class_line(cls)) from None
    names = [role.__name__ for role in roles]
    if not roles:
        raise ContractError("declares no role, and does not have the methods of any", class_line(cls))
    if len(roles) > 1:
        way = (
            "ask in one of them" if declared_roles(cls) else "say which it is with @role(...) above the class"
        )
        raise ContractError(f"has the methods of {', '.join(names)}; {way}", class_line(cls))
    return roles[0]


def example_of(cls: Any) -> Block:
    """A block with the defaults of its class, or the example of one of hydroservo's own that has none."""
    if cls in EXAMPLES:
        return EXAMPLES[cls]
    given = getattr(cls, "_field_defaults", {})
    open_fields = [name for name in cls._fields if name not in given]
    if open_fields:
        problem = (
            f"has no default for {', '.join(open_fields)}: give one, or call check_block with an example"
        )
        raise ContractError(problem, class_line(cls, open_fields[0]))
    made: Block = cls()
    return made


def bits(value: Any) -> Any:
    """What makes a number, an array, a block or a state the same to the last bit; all nan are one."""
    if is_block(value):
        return type(value).__name__, tuple((path, bits(leaf)) for path, leaf in leaves(value))
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, float):
        return CANONICAL_NAN if math.isnan(value) else struct.pack("<d", value)
    return type(value), value
