"""External forces on the rod."""

from hydroservo.loads.constant import Constant
from hydroservo.loads.sine import Sine

__all__ = [
    "Constant",
    "Sine",
]
