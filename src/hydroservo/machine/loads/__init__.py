"""External forces on the rod."""

from hydroservo.machine.loads.constant import Constant
from hydroservo.machine.loads.recorded import Recorded
from hydroservo.machine.loads.sine import Sine
from hydroservo.machine.loads.square import Square
from hydroservo.machine.loads.step import Step

__all__ = ["Constant", "Recorded", "Sine", "Square", "Step"]
