"""Where the pressure comes from."""

from hydroservo.supplies.ideal import IdealSupply, IdealSupplyState

__all__ = [
    "IdealSupply",
    "IdealSupplyState",
]
