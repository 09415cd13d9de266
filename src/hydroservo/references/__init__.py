"""Demands."""

from hydroservo.references.chirp import Chirp
from hydroservo.references.multisine import Multisine
from hydroservo.references.point_to_point import PointToPoint
from hydroservo.references.ramp import Ramp
from hydroservo.references.recorded import Recorded
from hydroservo.references.sine import Sine
from hydroservo.references.square import Square
from hydroservo.references.step import Step

__all__ = [
    "Chirp",
    "Multisine",
    "PointToPoint",
    "Ramp",
    "Recorded",
    "Sine",
    "Square",
    "Step",
]
