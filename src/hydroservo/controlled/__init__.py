"""What a loop controls."""

from hydroservo.controlled.command import Command
from hydroservo.controlled.force import Force
from hydroservo.controlled.load_force import LoadForce
from hydroservo.controlled.load_pressure import LoadPressure
from hydroservo.controlled.position import Position
from hydroservo.controlled.pressure_a import PressureA
from hydroservo.controlled.pressure_b import PressureB
from hydroservo.controlled.velocity import Velocity

__all__ = [
    "Command",
    "Force",
    "LoadForce",
    "LoadPressure",
    "Position",
    "PressureA",
    "PressureB",
    "Velocity",
]
