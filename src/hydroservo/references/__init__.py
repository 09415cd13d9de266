"""Velocity demands."""

from hydroservo.references.sine import Sine
from hydroservo.references.square import Square

__all__ = [
    "Sine",
    "Square",
]
