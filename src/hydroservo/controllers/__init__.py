"""Control laws, one a file, and what can be wrapped around them."""

from hydroservo.controllers.anti_windup import AntiWindup, AntiWindupState
from hydroservo.controllers.backstepping import Backstepping, BacksteppingState
from hydroservo.controllers.dac import DAC, DACState
from hydroservo.controllers.delay import Delay, DelayState
from hydroservo.controllers.explicit_reaching import ExplicitReaching
from hydroservo.controllers.implicit_reaching import ImplicitReaching
from hydroservo.controllers.pi import PI, PIState
from hydroservo.controllers.rate_limit import RateLimit, RateLimitState
from hydroservo.controllers.saturation import Saturation
from hydroservo.controllers.smooth_reaching import SmoothReaching
from hydroservo.controllers.tsmc import TSMC, TSMCState
from hydroservo.controllers.valve_inversion import ValveInversion, ValveInversionState

__all__ = [
    "DAC",
    "PI",
    "TSMC",
    "AntiWindup",
    "AntiWindupState",
    "Backstepping",
    "BacksteppingState",
    "DACState",
    "Delay",
    "DelayState",
    "ExplicitReaching",
    "ImplicitReaching",
    "PIState",
    "RateLimit",
    "RateLimitState",
    "Saturation",
    "SmoothReaching",
    "TSMCState",
    "ValveInversion",
    "ValveInversionState",
]
