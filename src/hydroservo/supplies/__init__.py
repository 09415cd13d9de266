"""Where the pressure comes from."""

from hydroservo.supplies.gas_accumulator import GasAccumulator
from hydroservo.supplies.ideal import IdealSupply, IdealSupplyState
from hydroservo.supplies.instant_poppet import InstantPoppet, InstantPoppetState
from hydroservo.supplies.no_accumulator import NoAccumulator
from hydroservo.supplies.pump import PumpSupply, PumpSupplyState
from hydroservo.supplies.relief import ReliefValve
from hydroservo.supplies.slow_poppet import SlowPoppet, SlowPoppetState

__all__ = [
    "GasAccumulator",
    "IdealSupply",
    "IdealSupplyState",
    "InstantPoppet",
    "InstantPoppetState",
    "NoAccumulator",
    "PumpSupply",
    "PumpSupplyState",
    "ReliefValve",
    "SlowPoppet",
    "SlowPoppetState",
]
