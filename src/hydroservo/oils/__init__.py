"""How compressible the oil is."""

from hydroservo.oils.aerated import AeratedOil
from hydroservo.oils.constant import ConstantOil

__all__ = ["AeratedOil", "ConstantOil"]
