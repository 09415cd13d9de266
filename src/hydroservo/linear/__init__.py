"""What a loop is for small motions: its linear models, its frequency response, its margins."""

from hydroservo.linear.bode import bode
from hydroservo.linear.linearization import Linearization
from hydroservo.linear.linearize import linearize
from hydroservo.linear.margins import Margins, margins

__all__ = ["Linearization", "Margins", "bode", "linearize", "margins"]
