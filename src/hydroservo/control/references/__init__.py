"""Demands."""

from hydroservo.control.references.chirp import Chirp
from hydroservo.control.references.multisine import Multisine
from hydroservo.control.references.point_to_point import PointToPoint
from hydroservo.control.references.ramp import Ramp
from hydroservo.control.references.recorded import Recorded
from hydroservo.control.references.sine import Sine
from hydroservo.control.references.square import Square
from hydroservo.control.references.step import Step
from hydroservo.control.references.there_and_back import ThereAndBack

__all__ = ["Chirp", "Multisine", "PointToPoint", "Ramp", "Recorded", "Sine", "Square", "Step", "ThereAndBack"]
