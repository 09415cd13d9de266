"""Where the pressure comes from."""

from hydroservo.machine.supplies.gas_accumulator import GasAccumulator
from hydroservo.machine.supplies.ideal import IdealSupply, IdealSupplyState
from hydroservo.machine.supplies.instant_poppet import InstantPoppet, InstantPoppetState
from hydroservo.machine.supplies.no_accumulator import NoAccumulator
from hydroservo.machine.supplies.pump import PumpSupply, PumpSupplyState
from hydroservo.machine.supplies.relief import ReliefValve
from hydroservo.machine.supplies.slow_poppet import SlowPoppet, SlowPoppetState

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
