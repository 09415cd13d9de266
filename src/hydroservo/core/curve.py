"""A quantity over another as a smooth function: a table, or over time a recorded signal."""

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.core import ops
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field

POINTS = "the points"


class Curve(NamedTuple):
    """Points joined by a monotone piecewise cubic (PCHIP), with its exact derivatives.

    Between knots i and i+1, with h = x - knots[i] and c = coefficients[:, i]::

        y(x) = ((c0 h + c1) h + c2) h + c3

    Make it with :meth:`from_samples`; the default is 0 everywhere. Outside the points the first or last one
    is held and both derivatives are 0. Between two points y lies between theirs: nothing overshoots, and the
    slope has no jumps at which a loop could chatter. A kink is as sharp as the points about it are close.

    A block declares the units of both: ``Annotated[Curve, Field("V/m", "gain", over="m/s")]``. Without
    ``over`` that is s, and the curve is a recorded signal, which ``TimeSeries`` is another name for.

    Source: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984, doi:10.1137/0905021, as computed by
    scipy.interpolate.PchipInterpolator.
    Fails as a source of the second derivative: that jumps at the knots. It removes no noise: filter first. It
    bridges holes in a record as it does steps; a run says so, and what else of it is made up.
    """

    knots: Annotated[NDArray[np.float64], Field("", "x of the points, in SI units, shape (n,)", POINTS)] = (
        np.array([0.0, 1.0])
    )
    coefficients: Annotated[
        NDArray[np.float64],
        Field("", "cubic coefficients, shape (4, n-1), in y's unit per x's^3, ^2, ^1 and 1", POINTS),
    ] = np.zeros((4, 1))

    @classmethod
    def from_samples(cls, x: ArrayLike, y: ArrayLike) -> "Curve":
        """The interpolant of points.

        Args:
            x: such as instants [s], in SI units, shape (n,), n at least 2, strictly increasing.
            y: the quantity there, in its own SI unit, shape (n,).

        Raises:
            ParameterError: the points are not that, or lie too close or too far apart for 64-bit numbers.
        """
        at, value = finite_vector("x", x), finite_vector("y", y)
        if at.size != value.size:
            raise ParameterError("y", f"{value.size} samples", f"must be as many as the {at.size} of x")
        if at.size < 2:
            raise ParameterError("x", f"{at.size} samples", "must be at least 2")
        back = np.flatnonzero(at[1:] <= at[:-1])
        if back.size:
            i = int(back[0])
            raise ParameterError(f"x[{i + 1}]", float(at[i + 1]), f"must be above x[{i}] = {at[i]:.17g}")
        return cls(at, monotone_cubic(at, value))

    @property
    def samples(self) -> NDArray[np.float64]:
        """y at the knots, in its own SI unit, shape (n,)."""
        return np.array([self.value(float(x)) for x in self.knots])

    def value(self, x: float) -> float:
        """y(x), in its own unit."""
        i = self.segment(x)
        h = self.inside(x) - float(self.knots[i])
        c = self.coefficients
        return ((float(c[0, i]) * h + float(c[1, i])) * h + float(c[2, i])) * h + float(c[3, i])

    def rate(self, x: float) -> float:
        """dy/dx, in y's unit per x's."""
        i = self.segment(x)
        h = self.inside(x) - float(self.knots[i])
        c = self.coefficients
        rate = (3.0 * float(c[0, i]) * h + 2.0 * float(c[1, i])) * h + float(c[2, i])
        return ops.where(self.inside(x) == x, rate, 0.0)

    def second_rate(self, x: float) -> float:
        """d2y/dx2, in y's unit per x's squared."""
        i = self.segment(x)
        h = self.inside(x) - float(self.knots[i])
        c = self.coefficients
        second_rate = 6.0 * float(c[0, i]) * h + 2.0 * float(c[1, i])
        return ops.where(self.inside(x) == x, second_rate, 0.0)

    def next_knot(self, x: float) -> float:
        """The first knot after ``x``, in its unit; inf if there is none."""
        first, after = float(self.knots[0]), float(self.knots[self.segment(x) + 1])
        return ops.where(x < first, first, ops.where(x < after, after, math.inf))

    def inside(self, x: float) -> float:
        """What is nearest to ``x`` between the first and the last knot."""
        return ops.clip(x, float(self.knots[0]), float(self.knots[-1]))

    def segment(self, x: float) -> int:
        """The number of the last knot, the end excepted, that ``x`` has reached; by bisection."""
        low, high = 0, self.knots.size - 1
        while high - low > 1:
            middle = (low + high) // 2
            if x >= float(self.knots[middle]):
                low = middle
            else:
                high = middle
        return low


def check_curve(curve: Curve, path: str) -> None:
    """Refuse arrays that are no curve: kernels search the knots and read the coefficients beside them."""
    knots, coefficients = curve
    made = "must come from Curve.from_samples"
    if knots.ndim != 1 or knots.size < 2 or coefficients.shape != (4, knots.size - 1):
        shapes = f"arrays of shapes {knots.shape} and {coefficients.shape}"
        raise ParameterError(path, shapes, made)
    if not (np.isfinite(knots).all() and (np.diff(knots) > 0.0).all()):
        raise ParameterError(f"{path}.knots", "in disorder", f"must increase; {made}")
    if not np.isfinite(coefficients).all():
        raise ParameterError(f"{path}.coefficients", "not finite", made)


def monotone_cubic(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """PCHIP coefficients, shape (4, n-1)."""
    from scipy.interpolate import PchipInterpolator

    try:
        with np.errstate(all="ignore"):
            coefficients = np.ascontiguousarray(PchipInterpolator(x, y).c, dtype=np.float64)
    except ValueError:  # scipy's own check of the slopes
        coefficients = np.full((4, 1), np.nan)
    if not np.isfinite(coefficients).all():
        raise ParameterError("y", float(np.abs(y).max()), "overflows in the slopes between samples")
    return coefficients


def finite_vector(name: str, samples: ArrayLike) -> NDArray[np.float64]:
    try:
        values = np.array(samples, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(
            name, type(samples).__name__, "must be a one-dimensional array of numbers"
        ) from None
    if values.ndim != 1:
        raise ParameterError(name, f"shape {values.shape}", "must have one dimension")
    wrong = np.flatnonzero(~np.isfinite(values))
    if wrong.size:
        i = int(wrong[0])
        raise ParameterError(f"{name}[{i}]", float(values[i]), "must be a finite number")
    return values
