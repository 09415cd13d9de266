"""Edges whose area is a curve over the spool's position."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.curve import Curve
from hydroservo.errors import ParameterError
from hydroservo.formatting import quantity
from hydroservo.roles import EdgeShape, role
from hydroservo.signals import EdgeOpenings
from hydroservo.sources import DATASHEET

__all__ = ["CurvedEdges", "FourCurves"]

MEANING = "opening of a straight edge with the same area"


def an_edge(name: str) -> Field:
    """The declaration of the curve of one edge."""
    return Field("m", f"{MEANING} as {name}, over its own opening", DATASHEET, over="m")


@role(EdgeShape)
class CurvedEdges(NamedTuple):
    """Edges of one shape, as of notches or round holes: each is as open as a straight one by h(x_v).

    h is the curve where that goes below 0, and else sgn(x_v) times the curve at abs(x_v), so that both
    directions are alike. P-A and B-T open by h and A-T and P-B by -h. Where h is 0 about 0, the edges
    overlap.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (port shape and flow gain); the curve, the
    datasheet.
    Fails beyond the last point, where the edges open no further, and where kinks are sharper than the points
    are close.
    """

    curve: Annotated[Curve, Field("m", f"{MEANING}, over the spool's position", DATASHEET, over="m")]

    def check(self) -> None:
        y = self.curve.samples
        if self.curve.knots[0] >= 0.0 and (y[0] != 0.0 or y.min() < 0.0):
            worst = float(y[0] or y.min())
            allowed = "must begin at 0 and not fall below, or be one of both directions that begins below 0"
            raise ParameterError("curve", quantity(worst, "m"), allowed)

    def openings(self, opening: float) -> EdgeOpenings:
        alike = float(self.curve.knots[0]) >= 0.0
        along = self.curve.value(ops.where(alike, ops.absolute(opening), opening))
        h = ops.where(alike, ops.copysign(along, opening), along)
        return EdgeOpenings(h, -h, -h, h)


@role(EdgeShape)
class FourCurves(NamedTuple):
    """Edges each of a shape of its own: one is as open as a straight one by h(x).

    x is the opening of that edge, x_v for P-A and B-T and -x_v for A-T and P-B, and h its curve. Below the
    curve's first point the edge closes as a straight one does: one that begins below 0 is open at null.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (port shape and flow gain); the curves, the
    datasheet.
    Fails as CurvedEdges does.
    """

    pa: Annotated[Curve, an_edge("P-A")]
    at: Annotated[Curve, an_edge("A-T")]
    pb: Annotated[Curve, an_edge("P-B")]
    bt: Annotated[Curve, an_edge("B-T")]

    def check(self) -> None:
        for name, curve in self._asdict().items():
            least = float(curve.samples.min())
            if least < 0.0:
                raise ParameterError(name, quantity(least, "m"), "must not be below 0, as no edge opens less")

    def openings(self, opening: float) -> EdgeOpenings:
        return EdgeOpenings(
            self.opened(self.pa, opening),
            self.opened(self.at, -opening),
            self.opened(self.pb, -opening),
            self.opened(self.bt, opening),
        )

    def opened(self, curve: Curve, own: float) -> float:
        """How far an edge is open, as a straight one [m]."""
        return curve.value(own) + ops.minimum(own - float(curve.knots[0]), 0.0)
