"""What is asked of: a block in a role, and what is said where it is not as it must be."""

import re
from pathlib import Path
from typing import NamedTuple

from hydroservo.block import Block
from hydroservo.scenario.fits import role_methods
from hydroservo.testing.lines import file_of, line_of

__all__ = ["PLAIN", "Case", "ContractError"]

PLAIN = {"simplified", "substeps_for", "trusted_rate"}  # methods of roles that only Python calls
NAMED = (  # how translation and numba name a place
    re.compile(r"^(?P<file>.+?), line (?P<line>\d+), "),
    re.compile(r' \(File "(?P<file>.+?)", line (?P<line>\d+)\)'),
)


class ContractError(AssertionError):
    """A block is not what a block must be.

    Attributes:
        line: of the block's file, 0 where that is not known.
    """

    def __init__(self, problem: str, line: int = 0) -> None:
        self.line = line
        super().__init__(problem)


class Case(NamedTuple):
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
        return [name for name in role_methods(self.role) if name not in PLAIN]

    def error(self, problem: str, member: str = "") -> ContractError:
        """What is wrong, at the line that the text names, or else of a field or method, or of the class."""
        for place in NAMED:
            named = place.search(problem)
            if named is not None and Path(named["file"]).name == Path(file_of(self.cls)).name:
                return ContractError(place.sub("", problem, count=1), int(named["line"]))
        return ContractError(problem, line_of(self.cls, member))
