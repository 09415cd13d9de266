"""The least error that any command can leave, by optimal control."""

from hydroservo.limits.least_error import Limits, limit
from hydroservo.limits.over_periods import LimitsAtPeriod, LimitsOverPeriods, limit_over_periods

__all__ = ["Limits", "LimitsAtPeriod", "LimitsOverPeriods", "limit", "limit_over_periods"]
