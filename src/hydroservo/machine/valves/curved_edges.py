"""Edges whose area is a curve over the spool's position."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import EdgeShape, role
from hydroservo.core.signals import EdgeOpenings
from hydroservo.core.sources import DATASHEET
from hydroservo.machine.valves.orifice import LARGEST_OPENING

FullOpening = Annotated[
    float, Field("m", "spool position at 100 %", DATASHEET, above=0, at_most=LARGEST_OPENING)
]


def a_curve(what: str) -> Field:
    """The declaration of an area over an opening, both as shares of those at full opening."""
    return Field(
        "", f"area of {what} over that at 100 %, over the share of the full opening", DATASHEET, over=""
    )


@role(EdgeShape)
class CurvedEdges(NamedTuple):
    """Edges of one shape, as of notches or round holes: each is as open as a straight one by h(x_v).

    h(x) = x_f f(x/x_f), with f the curve where that goes below 0, and else both directions alike,
    f(-x/x_f) = -f(x/x_f). P-A and B-T open by h and A-T and P-B by -h. Where f is 0 about 0, the edges
    overlap.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (port shape and flow gain); the curve, the
    datasheet.
    Fails beyond the last point, where the edges open no further, and where kinks are sharper than the points
    are close.
    """

    full_opening: FullOpening
    curve: Annotated[Curve, a_curve("each edge")]

    def check(self) -> None:
        f = self.curve.samples
        if self.curve.knots[0] >= 0.0 and (f[0] != 0.0 or f.min() < 0.0):
            allowed = "must begin at 0 and not fall below, or be one of both directions that begins below 0"
            raise ParameterError("curve", float(f[0] or f.min()), allowed)

    def openings(self, opening: float) -> EdgeOpenings:
        alike = float(self.curve.knots[0]) >= 0.0
        share = opening * (1.0 / self.full_opening)
        along = self.full_opening * self.curve.value(ops.where(alike, ops.absolute(share), share))
        h = ops.where(alike, ops.copysign(along, opening), along)
        return EdgeOpenings(h, -h, -h, h)


@role(EdgeShape)
class FourCurves(NamedTuple):
    """Edges each of a shape of its own: one is as open as a straight one by h(x) = x_f f(x/x_f).

    x is the opening of that edge, x_v for P-A and B-T and -x_v for A-T and P-B, and f its curve. Below the
    curve's first point the edge closes as a straight one does: one that begins below 0 is open at null.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (port shape and flow gain); the curves, the
    datasheet.
    Fails as CurvedEdges does.
    """

    full_opening: FullOpening
    pa: Annotated[Curve, a_curve("P-A")]
    at: Annotated[Curve, a_curve("A-T")]
    pb: Annotated[Curve, a_curve("P-B")]
    bt: Annotated[Curve, a_curve("B-T")]

    def check(self) -> None:
        for name in ("pa", "at", "pb", "bt"):
            least = float(getattr(self, name).samples.min())
            if least < 0.0:
                raise ParameterError(name, least, "must not be below 0, as no edge opens less")

    def openings(self, opening: float) -> EdgeOpenings:
        share = opening * (1.0 / self.full_opening)
        return EdgeOpenings(
            self.opened(self.pa, share),
            self.opened(self.at, -share),
            self.opened(self.pb, -share),
            self.opened(self.bt, share),
        )

    def opened(self, curve: Curve, share: float) -> float:
        """How far an edge is open, as a straight one [m]."""
        return self.full_opening * (curve.value(share) + ops.minimum(share - float(curve.knots[0]), 0.0))
