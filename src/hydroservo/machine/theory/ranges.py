"""What the arguments of a lemma must be."""

import math

from hydroservo.core.errors import ParameterError


def require_positive(name: str, value: float) -> None:
    """Raise a ParameterError unless the value is a finite number above 0."""
    if not (math.isfinite(value) and value > 0.0):
        raise ParameterError(name, value, "must be a finite number above 0")


def require_not_negative(name: str, value: float) -> None:
    """Raise a ParameterError unless the value is a finite number, at least 0."""
    if not (math.isfinite(value) and value >= 0.0):
        raise ParameterError(name, value, "must be a finite number, at least 0")


def require_fraction(name: str, value: float) -> None:
    """Raise a ParameterError unless the value lies between 0 and 1, both excluded."""
    if not 0.0 < value < 1.0:
        raise ParameterError(name, value, "must be a number above 0 and below 1")
