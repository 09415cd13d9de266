"""Control laws, one a file."""

from hydroservo.controllers.backstepping import Backstepping, BacksteppingState
from hydroservo.controllers.pi import PI, PIState
from hydroservo.controllers.saturation import Saturation
from hydroservo.controllers.tsmc import TSMC, TSMCState

__all__ = [
    "PI",
    "TSMC",
    "Backstepping",
    "BacksteppingState",
    "PIState",
    "Saturation",
    "TSMCState",
]
