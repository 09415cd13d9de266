"""What a loop controls."""

from hydroservo.control.controlled.command import Command
from hydroservo.control.controlled.force import Force
from hydroservo.control.controlled.hydraulic_force import HydraulicForce
from hydroservo.control.controlled.load_pressure import LoadPressure
from hydroservo.control.controlled.position import Position
from hydroservo.control.controlled.pressure_a import PressureA
from hydroservo.control.controlled.pressure_b import PressureB
from hydroservo.control.controlled.velocity import Velocity

__all__ = [
    "Command",
    "Force",
    "HydraulicForce",
    "LoadPressure",
    "Position",
    "PressureA",
    "PressureB",
    "Velocity",
]
