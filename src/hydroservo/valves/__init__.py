"""Servo valves and their metering edges."""

from hydroservo.valves.first_order import FirstOrderValve, FirstOrderValveState
from hydroservo.valves.orifice import Orifice
from hydroservo.valves.static import StaticValve, StaticValveState

__all__ = [
    "FirstOrderValve",
    "FirstOrderValveState",
    "Orifice",
    "StaticValve",
    "StaticValveState",
]
