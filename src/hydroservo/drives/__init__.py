"""What turns a command and the pressures at the cylinder's ports into the flows through them."""

from hydroservo.drives.check_valve import CheckValve
from hydroservo.drives.counterbalance import Counterbalance, CounterbalanceState
from hydroservo.drives.hoses import Hoses, HosesState
from hydroservo.drives.lines import Lines, LinesState
from hydroservo.drives.load_sensing import LoadSensing, LoadSensingState
from hydroservo.drives.port_valves import PortValves
from hydroservo.drives.pressure_compensator import PressureCompensator
from hydroservo.drives.pump_drive import PumpDrive, PumpDriveState
from hydroservo.drives.valve_on_supply import ValveOnSupply, ValveOnSupplyState, open_ports

__all__ = [
    "CheckValve",
    "Counterbalance",
    "CounterbalanceState",
    "Hoses",
    "HosesState",
    "Lines",
    "LinesState",
    "LoadSensing",
    "LoadSensingState",
    "PortValves",
    "PressureCompensator",
    "PumpDrive",
    "PumpDriveState",
    "ValveOnSupply",
    "ValveOnSupplyState",
    "open_ports",
]
