"""Edges that open as their spool moves."""

from typing import NamedTuple

from hydroservo.core.roles import EdgeShape, role
from hydroservo.core.signals import EdgeOpenings


@role(EdgeShape)
class StraightEdges(NamedTuple):
    """Edges around the whole spool, or of rectangular slots: each opens by as much as the spool moves.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (rectangular ports).
    Fails for notches and round holes, whose area is no straight line; see CurvedEdges.
    """

    def openings(self, opening: float) -> EdgeOpenings:
        return EdgeOpenings(opening, -opening, -opening, opening)
