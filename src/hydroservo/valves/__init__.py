"""Servo valves and their metering edges."""

from hydroservo.valves.first_order import FirstOrderValve, FirstOrderValveState
from hydroservo.valves.four_edges import FourEdges
from hydroservo.valves.no_valve import NoEdges, NoValve, NoValveState
from hydroservo.valves.orifice import Orifice
from hydroservo.valves.second_order import SecondOrderValve, SecondOrderValveState
from hydroservo.valves.static import StaticValve, StaticValveState

__all__ = [
    "FirstOrderValve",
    "FirstOrderValveState",
    "FourEdges",
    "NoEdges",
    "NoValve",
    "NoValveState",
    "Orifice",
    "SecondOrderValve",
    "SecondOrderValveState",
    "StaticValve",
    "StaticValveState",
]
