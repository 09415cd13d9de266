"""A recorded demand."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.time_series import TimeSeries


@role(Reference)
class Recorded(NamedTuple):
    """r read from a record, smoothly interpolated, held before its first and after its last sample.

    Source: the record; the interpolation and its two derivatives are those of
    :class:`~hydroservo.core.curve.Curve`.
    A run that sees nothing of the record is refused; one that sees held or bridged parts of it says so.
    Fails as a demand for laws that use its second derivative: that jumps at each sample of the record.
    """

    series: Annotated[TimeSeries, Field("y", "recorded demand", "the record")] = TimeSeries()

    def at(self, t: float) -> Demand:
        return Demand(self.series.value(t), self.series.rate(t), self.series.second_rate(t))
