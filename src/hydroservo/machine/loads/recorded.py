"""A recorded external force."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Load, role
from hydroservo.core.time_series import TimeSeries


@role(Load)
class Recorded(NamedTuple):
    """F_L read from a record, smoothly interpolated, positive against motion.

    Source: the record; the interpolation, which holds the first and last sample outside it, is that of
    :class:`~hydroservo.core.curve.Curve`.
    A run that sees nothing of the record is refused; one that sees held or bridged parts of it says so.
    Fails where the force depends on the motion, as that of a spring or of friction does.
    """

    series: Annotated[TimeSeries, Field("N", "recorded external force", "the record")] = TimeSeries()

    def force(self, t: float) -> float:
        return self.series.value(t)

    def next_jump(self, t: float) -> float:
        return self.series.next_knot(t)
