"""Where the pressure comes from."""

from hydroservo.supplies.gas_accumulator import GasAccumulator
from hydroservo.supplies.ideal import IdealSupply, IdealSupplyState
from hydroservo.supplies.no_accumulator import NoAccumulator
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
