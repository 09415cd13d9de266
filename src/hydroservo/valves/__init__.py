"""Servo valves and their metering edges."""

from hydroservo.valves.curved_edges import CurvedEdges, FourCurves
from hydroservo.valves.first_order import FirstOrderValve, FirstOrderValveState
from hydroservo.valves.four_edges import FourEdges
from hydroservo.valves.no_valve import NoEdges, NoValve, NoValveState
from hydroservo.valves.orifice import Orifice
from hydroservo.valves.second_order import SecondOrderValve, SecondOrderValveState
from hydroservo.valves.static import StaticValve, StaticValveState
from hydroservo.valves.straight_edges import StraightEdges

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
