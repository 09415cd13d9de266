"""Control laws, one a file, and what can be wrapped around them."""

from hydroservo.control.controllers.acceleration_feedback import (
    AccelerationFeedback,
    AccelerationFeedbackState,
)
from hydroservo.control.controllers.adaptive_robust import AdaptiveRobust, AdaptiveRobustState
from hydroservo.control.controllers.anti_windup import AntiWindup, AntiWindupState
from hydroservo.control.controllers.backstepping import Backstepping, BacksteppingState
from hydroservo.control.controllers.biquad import Biquad, BiquadState
from hydroservo.control.controllers.cascade import Cascade, CascadeState
from hydroservo.control.controllers.characteristic_compensation import (
    CharacteristicCompensation,
    CharacteristicCompensationState,
)
from hydroservo.control.controllers.dac import DAC, DACState
from hydroservo.control.controllers.dead_band_compensation import (
    DeadBandCompensation,
    DeadBandCompensationState,
)
from hydroservo.control.controllers.dead_band_jump import DeadBandJump, DeadBandJumpState
from hydroservo.control.controllers.delay import Delay, DelayState
from hydroservo.control.controllers.directional_gain import DirectionalGain, DirectionalGainState
from hydroservo.control.controllers.dither import Dither, DitherState
from hydroservo.control.controllers.first_order_adrc import FirstOrderADRC, FirstOrderADRCState
from hydroservo.control.controllers.fixed_demand import FixedDemand, FixedDemandState
from hydroservo.control.controllers.flow_compensation import FlowCompensation, FlowCompensationState
from hydroservo.control.controllers.force_limit import ForceLimit, ForceLimitState
from hydroservo.control.controllers.h_infinity import HInfinityLoopShaping, HInfinityLoopShapingState
from hydroservo.control.controllers.impedance import Impedance, ImpedanceState
from hydroservo.control.controllers.internal_model import InternalModel, InternalModelState
from hydroservo.control.controllers.inverted_polarity import InvertedPolarity, InvertedPolarityState
from hydroservo.control.controllers.inverting import Inverting, InvertingState
from hydroservo.control.controllers.linear_mpc import LinearMPC, LinearMPCState
from hydroservo.control.controllers.lqi import LQI, LQIState
from hydroservo.control.controllers.no_basis import NoBasis, NoBasisState
from hydroservo.control.controllers.offset_free_lq import OffsetFreeLQ, OffsetFreeLQState
from hydroservo.control.controllers.open_loop import OpenLoop, OpenLoopState
from hydroservo.control.controllers.pi import PI, PIState
from hydroservo.control.controllers.pid import PID, PIDState
from hydroservo.control.controllers.pressure_feedback import PressureFeedback, PressureFeedbackState
from hydroservo.control.controllers.radial_basis import RadialBasis
from hydroservo.control.controllers.rate_limit import RateLimit, RateLimitState
from hydroservo.control.controllers.reference_filter import ReferenceFilter, ReferenceFilterState
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.controllers.second_order_adrc import SecondOrderADRC, SecondOrderADRCState
from hydroservo.control.controllers.state_space import StateSpace, StateSpaceState
from hydroservo.control.controllers.tsmc import TSMC, TSMCState
from hydroservo.control.controllers.valve_inversion import ValveInversion, ValveInversionState
from hydroservo.control.controllers.velocity_compensation import (
    VelocityCompensation,
    VelocityCompensationState,
)

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
    "CharacteristicCompensation",
    "CharacteristicCompensationState",
    "DACState",
    "DeadBandCompensation",
    "DeadBandCompensationState",
    "DeadBandJump",
    "DeadBandJumpState",
    "Delay",
    "DelayState",
    "DirectionalGain",
    "DirectionalGainState",
    "Dither",
    "DitherState",
    "FirstOrderADRC",
    "FirstOrderADRCState",
    "FixedDemand",
    "FixedDemandState",
    "FlowCompensation",
    "FlowCompensationState",
    "ForceLimit",
    "ForceLimitState",
    "HInfinityLoopShaping",
    "HInfinityLoopShapingState",
    "Impedance",
    "ImpedanceState",
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
