"""What a run is judged by: numbers gathered while it goes on, in memory that does not grow with it."""

from hydroservo.control.monitors.chamber_pressures import ChamberPressures
from hydroservo.control.monitors.command_effort import CommandEffort
from hydroservo.control.monitors.command_energy import CommandEnergy
from hydroservo.control.monitors.contact_force import ContactForce
from hydroservo.control.monitors.disturbance import Disturbance
from hydroservo.control.monitors.energy import Energy
from hydroservo.control.monitors.integral_criteria import IntegralCriteria
from hydroservo.control.monitors.oscillation import Oscillation
from hydroservo.control.monitors.piston_travel import PistonTravel
from hydroservo.control.monitors.rise_time import RiseTime
from hydroservo.control.monitors.step_response import StepResponse
from hydroservo.control.monitors.supply_line import SupplyLine
from hydroservo.control.monitors.tracking_error import TrackingError

__all__ = [
    "ChamberPressures",
    "CommandEffort",
    "CommandEnergy",
    "ContactForce",
    "Disturbance",
    "Energy",
    "IntegralCriteria",
    "Oscillation",
    "PistonTravel",
    "RiseTime",
    "StepResponse",
    "SupplyLine",
    "TrackingError",
]
