"""What turns a command and the pressures at the cylinder's ports into the flows through them."""

from hydroservo.machine.drives.check_valve import CheckValve
from hydroservo.machine.drives.counterbalance import Counterbalance, CounterbalanceState
from hydroservo.machine.drives.hoses import Hoses, HosesState
from hydroservo.machine.drives.lines import Lines, LinesState
from hydroservo.machine.drives.load_sensing import LoadSensing, LoadSensingState
from hydroservo.machine.drives.port_valves import PortValves
from hydroservo.machine.drives.pressure_compensator import PressureCompensator
from hydroservo.machine.drives.pump_drive import PumpDrive, PumpDriveState
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply, ValveOnSupplyState, open_ports

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
