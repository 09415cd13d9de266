"""How compressible the oil is, and what its temperature makes of it."""

from hydroservo.oils.aerated import AeratedOil
from hydroservo.oils.cavitating import CavitatingOil
from hydroservo.oils.constant import ConstantOil

__all__ = ["AeratedOil", "CavitatingOil", "ConstantOil"]
