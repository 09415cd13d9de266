"""External forces on the rod."""

from hydroservo.loads.constant import Constant
from hydroservo.loads.recorded import Recorded
from hydroservo.loads.sine import Sine
from hydroservo.loads.square import Square
from hydroservo.loads.step import Step

__all__ = [
    "Constant",
    "Recorded",
    "Sine",
    "Square",
    "Step",
]
