"""A curve over time, which a recorded signal is."""

from hydroservo.core.curve import Curve

TimeSeries = Curve  # over [s], as a Field is that says nothing else
