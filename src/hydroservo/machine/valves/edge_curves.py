"""The shape of edges from the curves of a datasheet."""

from typing import NamedTuple

import numpy as np

from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import quantity
from hydroservo.core.roles import EdgeShape
from hydroservo.machine.valves.curved_edges import CurvedEdges, FourCurves
from hydroservo.machine.valves.straight_edges import StraightEdges

STRAIGHT = Curve(np.array([0.0, 1.0]), np.array([[0.0], [0.0], [1.0], [0.0]]))  # stands for no curve
MOST = 10.0  # rated openings that a curve may go on to; more is a share for a percentage
ROUNDED = 1e-9


class ShapedEdges(NamedTuple):
    """The shape of edges and where it has its scale from."""

    shape: EdgeShape  # of which P-A is open by as much as the spool moves where that is fully open
    at_full: float  # what the curve of P-A has at full opening, in its own unit; 0 without curves


class EdgeCurves(NamedTuple):
    """Flows or areas of edges over an opening, in SI units; STRAIGHT where there is none."""

    name: str  # of the key of that for all edges; those of each edge end with its ports
    unit: str  # of the curves
    every: Curve  # of all edges that have none of their own
    pa: Curve  # of each edge, over its own opening, as the others
    at: Curve
    pb: Curve
    bt: Curve

    def of_share(self, full_opening: float) -> ShapedEdges:
        """The shape where the curves are over the share of a full opening [m].

        Raises:
            ParameterError: a curve does not reach that, or is not one of edges.
        """
        return self.shaped(1.0, full_opening)

    def over_opening(self) -> ShapedEdges:
        """The shape where the curves are over the opening [m], its end that of P-A's curve.

        Raises:
            ParameterError: a curve is not one of edges.
        """
        return self.shaped(self.full_opening(), self.full_opening())

    def full_opening(self) -> float:
        """The last point of P-A's curve."""
        return float((self.every if is_straight(self.pa) else self.pa).knots[-1])

    def shaped(self, full: float, full_opening: float) -> ShapedEdges:
        """The shape, of which the curves have the full opening at ``full``."""
        own = {f"{self.name}_{edge}": getattr(self, edge) for edge in ("pa", "at", "pb", "bt")}
        if all(is_straight(curve) for curve in own.values()):
            if is_straight(self.every):
                return ShapedEdges(StraightEdges(), 0.0)
            signed = self.signed(full)
            top = signed.value(full)
            return ShapedEdges(CurvedEdges(full_opening, scaled_curve(signed, full, top)), top)
        whole = {name: self.filled(name, curve, full) for name, curve in own.items()}
        top = whole[f"{self.name}_pa"].value(full)
        return ShapedEdges(
            FourCurves(full_opening, *(scaled_curve(curve, full, top) for curve in whole.values())), top
        )

    def signed(self, full: float) -> Curve:
        """The curve for all edges, its values below 0 where the spool is.

        Raises:
            ParameterError: it is not one of edges.
        """
        x, y = self.every.knots, self.every.samples
        reaches(self.name, x, full)
        both = x[0] < 0.0
        if both and x[0] > -full * (1.0 - ROUNDED):
            allowed = "must begin at 0, for both directions alike, or go from -100 %"
            raise ParameterError(self.name, f"begins at {share(x[0], full)}", allowed)
        if both and y[0] > 0.0:  # sizes
            y = np.where(x < 0.0, -y, y)
        elif not both and y[0] != 0.0:
            allowed = (
                f"must be 0 where it begins, at {share(x[0], full)}; one of each direction begins below 0"
            )
            raise ParameterError(self.name, quantity(float(y[0]), self.unit), allowed)
        elif not both and y.min() < 0.0:
            raise ParameterError(self.name, quantity(float(y.min()), self.unit), "must not be below 0")
        curve = Curve.from_samples(x, y)
        for end in (full, -full) if both else (full,):
            if not curve.value(end) * end > 0.0:
                shown = quantity(curve.value(end), self.unit)
                sign = "above" if end > 0.0 else "below"
                raise ParameterError(self.name, shown, f"must be {sign} 0 at {share(end, full)}")
        return curve

    def filled(self, name: str, curve: Curve, full: float) -> Curve:
        """The curve of one edge over its own opening: its own, or what that of all has for it.

        Raises:
            ParameterError: there is neither, or it is not one of an edge.
        """
        if is_straight(curve):
            if is_straight(self.every):
                raise ParameterError(name, "missing", f"must be given, or {self.name} for all edges")
            curve = half(self.signed(full), name.endswith(("at", "pb")))
        x, y = curve.knots, curve.samples
        reaches(name, x, full)
        least = float(y.min())
        if least < 0.0:
            raise ParameterError(name, quantity(least, self.unit), "must not be below 0")
        if not curve.value(full) > 0.0:
            raise ParameterError(name, "0", "must be above 0 at 100 %")
        return curve


def is_straight(curve: Curve) -> bool:
    """Whether a curve is the one that stands for none."""
    return all(np.array_equal(one, other) for one, other in zip(curve, STRAIGHT, strict=True))


def reaches(name: str, x: np.ndarray, full: float) -> None:
    """Refuse a curve that ends before full opening, or so far beyond that its unit is another.

    Raises:
        ParameterError: it does.
    """
    if not full * (1.0 - ROUNDED) <= x[-1] <= MOST * full:
        allowed = f"must go on to full opening, 100 %, and at most to {100.0 * MOST:g} %"
        raise ParameterError(name, f"ends at {share(x[-1], full)}", allowed)


def share(x: float, full: float) -> str:
    return f"{100.0 * x / full:.4g} %"


def half(curve: Curve, below: bool) -> Curve:
    """One direction of a curve of two, over the opening in that direction; a curve of one as it is."""
    x, y = curve.knots, curve.samples
    if x[0] >= 0.0:
        return curve
    x, y = (-x[::-1], -y[::-1]) if below else (x, y)
    at_0 = max(-curve.value(0.0) if below else curve.value(0.0), 0.0)
    return Curve.from_samples([0.0, *x[x > 0.0]], [at_0, *np.maximum(y[x > 0.0], 0.0)])


def scaled_curve(curve: Curve, x: float, y: float) -> Curve:
    """A curve over the share of x, as a share of y."""
    return Curve.from_samples(curve.knots / x, curve.samples / y)
