"""The least error that any command can leave, by optimal control."""

from hydroservo.limits.least_error import Limits, limit

__all__ = ["Limits", "limit"]
