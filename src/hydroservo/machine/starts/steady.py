"""A run that starts where its machine has settled."""

from collections.abc import Callable
from typing import Annotated, NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.group import group
from hydroservo.core.roles import Start, role
from hydroservo.core.sources import CHOSEN
from hydroservo.core.states import overlaid


@role(Start)
class Steady(NamedTuple):
    """The machine starts in the steady state that it takes under a command and the load at t = 0.

    All its rates but that of the position are 0: the piston rests at its start, or moves evenly if the
    command asks for that. The state is found before the run, by :func:`~hydroservo.runs.steady.steady_state`,
    and given to the blocks as AsBuilt does; states that are given stay as they are. The controller starts as
    it does otherwise.

    Source: the definition of an operating point.
    Fails where none exists, which is said in one line; to say that a load is more than the supply holds,
    where the state is one that it drives back evenly; and where there are many, as with a valve that seals at
    null: one near the machine's own start is taken.
    """

    command: Annotated[float, Field("V", "command under which the machine has settled", CHOSEN)] = 0.0
    given: Block = group({})

    def found(self, steady: Callable[[float], Block]) -> Block:
        """The steady state under the command, for a run."""
        return steady(self.command)

    def of(self, s: Block) -> Block:
        """The state before the steady one is found."""
        return overlaid(s, self.given)
