"""How compressible the oil is, and what its temperature makes of it."""

from hydroservo.machine.oils.aerated import AeratedOil
from hydroservo.machine.oils.cavitating import CavitatingOil
from hydroservo.machine.oils.constant import ConstantOil

__all__ = ["AeratedOil", "CavitatingOil", "ConstantOil"]
