"""Servo valves and their metering edges."""

from hydroservo.machine.valves.curved_edges import CurvedEdges, FourCurves
from hydroservo.machine.valves.first_order import FirstOrderValve, FirstOrderValveState
from hydroservo.machine.valves.four_edges import FourEdges
from hydroservo.machine.valves.no_valve import NoEdges, NoValve, NoValveState
from hydroservo.machine.valves.orifice import Orifice
from hydroservo.machine.valves.second_order import SecondOrderValve, SecondOrderValveState
from hydroservo.machine.valves.static import StaticValve, StaticValveState
from hydroservo.machine.valves.straight_edges import StraightEdges

__all__ = [
    "CurvedEdges",
    "FirstOrderValve",
    "FirstOrderValveState",
    "FourCurves",
    "FourEdges",
    "NoEdges",
    "NoValve",
    "NoValveState",
    "Orifice",
    "SecondOrderValve",
    "SecondOrderValveState",
    "StaticValve",
    "StaticValveState",
    "StraightEdges",
]
