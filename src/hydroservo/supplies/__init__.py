"""Where the pressure comes from."""

from hydroservo.supplies.accumulator import GasAccumulator, NoAccumulator
from hydroservo.supplies.ideal import IdealSupply, IdealSupplyState
from hydroservo.supplies.pump import PumpSupply, PumpSupplyState
from hydroservo.supplies.relief import ReliefValve

__all__ = [
    "GasAccumulator",
    "IdealSupply",
    "IdealSupplyState",
    "NoAccumulator",
    "PumpSupply",
    "PumpSupplyState",
    "ReliefValve",
]
