"""Where the pressure comes from."""

from hydroservo.supplies.gas_accumulator import GasAccumulator
from hydroservo.supplies.ideal import IdealSupply, IdealSupplyState
from hydroservo.supplies.no_accumulator import NoAccumulator
from hydroservo.supplies.pump import PumpSupply, PumpSupplyState
from hydroservo.supplies.quick_poppet import QuickPoppet, QuickPoppetState
from hydroservo.supplies.relief import ReliefValve
from hydroservo.supplies.slow_poppet import SlowPoppet, SlowPoppetState

__all__ = [
    "GasAccumulator",
    "IdealSupply",
    "IdealSupplyState",
    "NoAccumulator",
    "PumpSupply",
    "PumpSupplyState",
    "QuickPoppet",
    "QuickPoppetState",
    "ReliefValve",
    "SlowPoppet",
    "SlowPoppetState",
]
