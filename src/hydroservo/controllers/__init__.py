"""Control laws, one a file, and what can be wrapped around them."""

from hydroservo.controllers.anti_windup import AntiWindup, AntiWindupState
from hydroservo.controllers.backstepping import Backstepping, BacksteppingState
from hydroservo.controllers.dac import DAC, DACState
from hydroservo.controllers.delay import Delay, DelayState
from hydroservo.controllers.pi import PI, PIState
from hydroservo.controllers.rate_limit import RateLimit, RateLimitState
from hydroservo.controllers.saturation import Saturation
from hydroservo.controllers.tsmc import TSMC, TSMCState

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
    "PIState",
    "RateLimit",
    "RateLimitState",
    "Saturation",
    "TSMCState",
]
