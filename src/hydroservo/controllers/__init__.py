"""Control laws, one a file."""

from hydroservo.controllers.backstepping import Backstepping, BacksteppingState
from hydroservo.controllers.explicit_reaching import ExplicitReaching
from hydroservo.controllers.implicit_reaching import ImplicitReaching
from hydroservo.controllers.pi import PI, PIState
from hydroservo.controllers.saturation import Saturation
from hydroservo.controllers.smooth_reaching import SmoothReaching
from hydroservo.controllers.tsmc import TSMC, TSMCState
from hydroservo.controllers.valve_inversion import ValveInversion, ValveInversionState

__all__ = [
    "PI",
    "TSMC",
    "Backstepping",
    "BacksteppingState",
    "ExplicitReaching",
    "ImplicitReaching",
    "PIState",
    "Saturation",
    "SmoothReaching",
    "TSMCState",
    "ValveInversion",
    "ValveInversionState",
]
