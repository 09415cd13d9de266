"""A run that starts as its blocks do."""

from typing import NamedTuple

from hydroservo.core.block import Block
from hydroservo.core.group import group
from hydroservo.core.roles import Start, role
from hydroservo.core.states import overlaid


@role(Start)
class AsBuilt(NamedTuple):
    """Each block starts in its own first state, but for the states that are given.

    ``given`` holds numbers of the loop's state under their names, as
    :func:`~hydroservo.core.group.nested` makes it: ``AsBuilt(nested({"plant.velocity": 0.1,
    "controller.integral": 0.5}))``.

    Source: a definition.
    Fails to ask whether the states given go together: the run begins with a jump of their rates where not.
    """

    given: Block = group({})

    def of(self, s: Block) -> Block:
        return overlaid(s, self.given)
