"""A recorded signal as a smooth function of time."""

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo import ops
from hydroservo.errors import ParameterError
from hydroservo.field import Field

__all__ = ["TimeSeries", "check_series"]

RECORD = "the record"


class TimeSeries(NamedTuple):
    """Samples joined by a monotone piecewise cubic (PCHIP), with its exact derivatives.

    Between knots i and i+1, with h = t - knots[i] and c = coefficients[:, i]::

        x(t) = ((c0 h + c1) h + c2) h + c3

    Make it with :meth:`from_samples`; the default is 0 everywhere. Outside the record the first or last
    sample is held and both derivatives are 0.

    Source: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984, doi:10.1137/0905021, as computed by
    scipy.interpolate.PchipInterpolator.
    Fails as a source of the second derivative: that jumps at the knots. It removes no noise: filter first. It
    bridges holes in a record as it does steps; a run says so, and what else of it is made up.
    """

    knots: Annotated[NDArray[np.float64], Field("s", "instants of the samples, shape (n,)", RECORD)] = (
        np.array([0.0, 1.0])
    )
    coefficients: Annotated[
        NDArray[np.float64],
        Field("", "cubic coefficients, shape (4, n-1), in the signal's unit per s^3, s^2, s and 1", RECORD),
    ] = np.zeros((4, 1))

    @classmethod
    def from_samples(cls, time: ArrayLike, value: ArrayLike) -> "TimeSeries":
        """The interpolant of samples.

        Args:
            time: instants [s], shape (n,), n at least 2, strictly increasing.
            value: the signal there, in its own unit, shape (n,).

        Raises:
            ParameterError: the samples are not that, or lie too close or too far apart for 64-bit numbers.
        """
        t, x = column("time", time), column("value", value)
        if t.size != x.size:
            raise ParameterError("value", f"{x.size} samples", f"must be as many as the {t.size} instants")
        if t.size < 2:
            raise ParameterError("time", f"{t.size} samples", "must be at least 2")
        late = np.flatnonzero(t[1:] <= t[:-1])
        if late.size:
            i = int(late[0])
            raise ParameterError(
                f"time[{i + 1}]", float(t[i + 1]), f"must be after time[{i}] = {t[i]:.17g} s"
            )
        return cls(t, monotone_cubic(t, x))

    def value(self, t: float) -> float:
        """x(t), in the signal's unit."""
        i = self.segment(t)
        h = self.inside(t) - float(self.knots[i])
        c = self.coefficients
        return ((float(c[0, i]) * h + float(c[1, i])) * h + float(c[2, i])) * h + float(c[3, i])

    def rate(self, t: float) -> float:
        """dx/dt, in the signal's unit per second."""
        i = self.segment(t)
        h = self.inside(t) - float(self.knots[i])
        c = self.coefficients
        rate = (3.0 * float(c[0, i]) * h + 2.0 * float(c[1, i])) * h + float(c[2, i])
        return ops.where(self.inside(t) == t, rate, 0.0)

    def second_rate(self, t: float) -> float:
        """d2x/dt2, in the signal's unit per second squared."""
        i = self.segment(t)
        h = self.inside(t) - float(self.knots[i])
        c = self.coefficients
        second_rate = 6.0 * float(c[0, i]) * h + 2.0 * float(c[1, i])
        return ops.where(self.inside(t) == t, second_rate, 0.0)

    def next_knot(self, t: float) -> float:
        """The first knot after ``t`` [s]; inf if there is none."""
        first, after = float(self.knots[0]), float(self.knots[self.segment(t) + 1])
        return ops.where(t < first, first, ops.where(t < after, after, math.inf))

    def inside(self, t: float) -> float:
        """The instant of the record that is nearest to ``t`` [s]."""
        return ops.clip(t, float(self.knots[0]), float(self.knots[-1]))

    def segment(self, t: float) -> int:
        """The number of the last knot, the end excepted, that ``t`` has reached; by bisection."""
        low, high = 0, self.knots.size - 1
        while high - low > 1:
            middle = (low + high) // 2
            if t >= float(self.knots[middle]):
                low = middle
            else:
                high = middle
        return low


def check_series(series: TimeSeries, path: str) -> None:
    """Refuse arrays that are no record: kernels search the knots and read the coefficients beside them.

    Raises:
        ParameterError: they are not as :meth:`TimeSeries.from_samples` makes them.
    """
    knots, coefficients = series
    made = "must come from TimeSeries.from_samples"
    if knots.ndim != 1 or knots.size < 2 or coefficients.shape != (4, knots.size - 1):
        shapes = f"arrays of shapes {knots.shape} and {coefficients.shape}"
        raise ParameterError(path, shapes, made)
    if not (np.isfinite(knots).all() and (np.diff(knots) > 0.0).all()):
        raise ParameterError(f"{path}.knots", "instants in disorder", f"must increase; {made}")
    if not np.isfinite(coefficients).all():
        raise ParameterError(f"{path}.coefficients", "not finite", made)


def monotone_cubic(t: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """PCHIP coefficients, shape (4, n-1).

    Raises:
        ParameterError: they overflow.
    """
    from scipy.interpolate import PchipInterpolator

    try:
        with np.errstate(all="ignore"):
            coefficients = np.ascontiguousarray(PchipInterpolator(t, x).c, dtype=np.float64)
    except ValueError:  # scipy's own check of the slopes
        coefficients = np.full((4, 1), np.nan)
    if not np.isfinite(coefficients).all():
        raise ParameterError("value", float(np.abs(x).max()), "overflows in the slopes between samples")
    return coefficients


def column(name: str, samples: ArrayLike) -> NDArray[np.float64]:
    """Samples as a vector of finite numbers.

    Raises:
        ParameterError: they are not.
    """
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
