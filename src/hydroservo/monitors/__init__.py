"""What a run is judged by: numbers gathered while it goes on, in memory that does not grow with it."""

from hydroservo.monitors.chamber_pressures import ChamberPressures
from hydroservo.monitors.command_effort import CommandEffort
from hydroservo.monitors.command_energy import CommandEnergy
from hydroservo.monitors.disturbance import Disturbance
from hydroservo.monitors.energy import Energy
from hydroservo.monitors.integral_criteria import IntegralCriteria
from hydroservo.monitors.oscillation import Oscillation
from hydroservo.monitors.piston_travel import PistonTravel
from hydroservo.monitors.rise_time import RiseTime
from hydroservo.monitors.step_response import StepResponse
from hydroservo.monitors.supply_line import SupplyLine
from hydroservo.monitors.tracking_error import TrackingError

__all__ = [
    "ChamberPressures",
    "CommandEffort",
    "CommandEnergy",
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
