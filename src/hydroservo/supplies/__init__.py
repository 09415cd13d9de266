"""Where the pressure comes from."""

from hydroservo.supplies.ideal import IdealSupply

__all__ = [
    "IdealSupply",
]
