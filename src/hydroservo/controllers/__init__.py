"""Control laws, one a file, and what can be wrapped around them."""

from hydroservo.controllers.acceleration_feedback import AccelerationFeedback, AccelerationFeedbackState
from hydroservo.controllers.anti_windup import AntiWindup, AntiWindupState
from hydroservo.controllers.backstepping import Backstepping, BacksteppingState
from hydroservo.controllers.cascade import Cascade, CascadeState
from hydroservo.controllers.dac import DAC, DACState
from hydroservo.controllers.dead_band_compensation import DeadBandCompensation, DeadBandCompensationState
from hydroservo.controllers.dead_band_jump import DeadBandJump, DeadBandJumpState
from hydroservo.controllers.delay import Delay, DelayState
from hydroservo.controllers.directional_gain import DirectionalGain, DirectionalGainState
from hydroservo.controllers.explicit_reaching import ExplicitReaching
from hydroservo.controllers.flow_compensation import FlowCompensation, FlowCompensationState
from hydroservo.controllers.implicit_reaching import ImplicitReaching
from hydroservo.controllers.inverted_polarity import InvertedPolarity, InvertedPolarityState
from hydroservo.controllers.open_loop import OpenLoop, OpenLoopState
from hydroservo.controllers.pi import PI, PIState
from hydroservo.controllers.pid import PID, PIDState
from hydroservo.controllers.pressure_feedback import PressureFeedback, PressureFeedbackState
from hydroservo.controllers.rate_limit import RateLimit, RateLimitState
from hydroservo.controllers.saturation import Saturation
from hydroservo.controllers.smooth_reaching import SmoothReaching
from hydroservo.controllers.tsmc import TSMC, TSMCState
from hydroservo.controllers.valve_inversion import ValveInversion, ValveInversionState
from hydroservo.controllers.velocity_compensation import VelocityCompensation, VelocityCompensationState

__all__ = [
    "DAC",
    "PI",
    "PID",
    "TSMC",
    "AccelerationFeedback",
    "AccelerationFeedbackState",
    "AntiWindup",
    "AntiWindupState",
    "Backstepping",
    "BacksteppingState",
    "Cascade",
    "CascadeState",
    "DACState",
    "DeadBandCompensation",
    "DeadBandCompensationState",
    "DeadBandJump",
    "DeadBandJumpState",
    "Delay",
    "DelayState",
    "DirectionalGain",
    "DirectionalGainState",
    "ExplicitReaching",
    "FlowCompensation",
    "FlowCompensationState",
    "ImplicitReaching",
    "InvertedPolarity",
    "InvertedPolarityState",
    "OpenLoop",
    "OpenLoopState",
    "PIDState",
    "PIState",
    "PressureFeedback",
    "PressureFeedbackState",
    "RateLimit",
    "RateLimitState",
    "Saturation",
    "SmoothReaching",
    "TSMCState",
    "ValveInversion",
    "ValveInversionState",
    "VelocityCompensation",
    "VelocityCompensationState",
]
