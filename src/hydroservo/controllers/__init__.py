"""Control laws, one a file, and what can be wrapped around them."""

from hydroservo.controllers.acceleration_feedback import AccelerationFeedback, AccelerationFeedbackState
from hydroservo.controllers.adaptive_robust import AdaptiveRobust, AdaptiveRobustState
from hydroservo.controllers.anti_windup import AntiWindup, AntiWindupState
from hydroservo.controllers.backstepping import Backstepping, BacksteppingState
from hydroservo.controllers.biquad import Biquad, BiquadState
from hydroservo.controllers.cascade import Cascade, CascadeState
from hydroservo.controllers.dac import DAC, DACState
from hydroservo.controllers.dead_band_compensation import DeadBandCompensation, DeadBandCompensationState
from hydroservo.controllers.dead_band_jump import DeadBandJump, DeadBandJumpState
from hydroservo.controllers.delay import Delay, DelayState
from hydroservo.controllers.directional_gain import DirectionalGain, DirectionalGainState
from hydroservo.controllers.first_order_adrc import FirstOrderADRC, FirstOrderADRCState
from hydroservo.controllers.flow_compensation import FlowCompensation, FlowCompensationState
from hydroservo.controllers.h_infinity import HInfinityLoopShaping, HInfinityLoopShapingState
from hydroservo.controllers.internal_model import InternalModel, InternalModelState
from hydroservo.controllers.inverted_polarity import InvertedPolarity, InvertedPolarityState
from hydroservo.controllers.inverting import Inverting, InvertingState
from hydroservo.controllers.linear_mpc import LinearMPC, LinearMPCState
from hydroservo.controllers.lqi import LQI, LQIState
from hydroservo.controllers.no_basis import NoBasis, NoBasisState
from hydroservo.controllers.offset_free_lq import OffsetFreeLQ, OffsetFreeLQState
from hydroservo.controllers.open_loop import OpenLoop, OpenLoopState
from hydroservo.controllers.pi import PI, PIState
from hydroservo.controllers.pid import PID, PIDState
from hydroservo.controllers.pressure_feedback import PressureFeedback, PressureFeedbackState
from hydroservo.controllers.radial_basis import RadialBasis
from hydroservo.controllers.rate_limit import RateLimit, RateLimitState
from hydroservo.controllers.reference_filter import ReferenceFilter, ReferenceFilterState
from hydroservo.controllers.saturation import Saturation
from hydroservo.controllers.second_order_adrc import SecondOrderADRC, SecondOrderADRCState
from hydroservo.controllers.state_space import StateSpace, StateSpaceState
from hydroservo.controllers.tsmc import TSMC, TSMCState
from hydroservo.controllers.valve_inversion import ValveInversion, ValveInversionState
from hydroservo.controllers.velocity_compensation import VelocityCompensation, VelocityCompensationState

__all__ = [
    "DAC",
    "LQI",
    "PI",
    "PID",
    "TSMC",
    "AccelerationFeedback",
    "AccelerationFeedbackState",
    "AdaptiveRobust",
    "AdaptiveRobustState",
    "AntiWindup",
    "AntiWindupState",
    "Backstepping",
    "BacksteppingState",
    "Biquad",
    "BiquadState",
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
    "FirstOrderADRC",
    "FirstOrderADRCState",
    "FlowCompensation",
    "FlowCompensationState",
    "HInfinityLoopShaping",
    "HInfinityLoopShapingState",
    "InternalModel",
    "InternalModelState",
    "InvertedPolarity",
    "InvertedPolarityState",
    "Inverting",
    "InvertingState",
    "LQIState",
    "LinearMPC",
    "LinearMPCState",
    "NoBasis",
    "NoBasisState",
    "OffsetFreeLQ",
    "OffsetFreeLQState",
    "OpenLoop",
    "OpenLoopState",
    "PIDState",
    "PIState",
    "PressureFeedback",
    "PressureFeedbackState",
    "RadialBasis",
    "RateLimit",
    "RateLimitState",
    "ReferenceFilter",
    "ReferenceFilterState",
    "Saturation",
    "SecondOrderADRC",
    "SecondOrderADRCState",
    "StateSpace",
    "StateSpaceState",
    "TSMCState",
    "ValveInversion",
    "ValveInversionState",
    "VelocityCompensation",
    "VelocityCompensationState",
]
