"""How a law wants its error to vanish: what differs between most laws of relative degree two."""

from hydroservo.control.error_dynamics.adaptive_super_twisting import (
    AdaptiveSuperTwisting,
    AdaptiveSuperTwistingState,
)
from hydroservo.control.error_dynamics.explicit_reaching import ExplicitReaching
from hydroservo.control.error_dynamics.homogeneous import (
    HomogeneousErrorDynamics,
    HomogeneousErrorDynamicsState,
)
from hydroservo.control.error_dynamics.implicit_reaching import ImplicitReaching
from hydroservo.control.error_dynamics.linear import LinearErrorDynamics, LinearErrorDynamicsState
from hydroservo.control.error_dynamics.naive_super_twisting import NaiveSuperTwisting, NaiveSuperTwistingState
from hydroservo.control.error_dynamics.nonsingular_terminal import (
    NonsingularTerminalErrorDynamics,
    NonsingularTerminalErrorDynamicsState,
)
from hydroservo.control.error_dynamics.rise import RISEErrorDynamics, RISEErrorDynamicsState
from hydroservo.control.error_dynamics.smooth_reaching import SmoothReaching
from hydroservo.control.error_dynamics.super_twisting import SuperTwisting, SuperTwistingState
from hydroservo.control.error_dynamics.terminal import TerminalErrorDynamics, TerminalErrorDynamicsState

__all__ = [
    "AdaptiveSuperTwisting",
    "AdaptiveSuperTwistingState",
    "ExplicitReaching",
    "HomogeneousErrorDynamics",
    "HomogeneousErrorDynamicsState",
    "ImplicitReaching",
    "LinearErrorDynamics",
    "LinearErrorDynamicsState",
    "NaiveSuperTwisting",
    "NaiveSuperTwistingState",
    "NonsingularTerminalErrorDynamics",
    "NonsingularTerminalErrorDynamicsState",
    "RISEErrorDynamics",
    "RISEErrorDynamicsState",
    "SmoothReaching",
    "SuperTwisting",
    "SuperTwistingState",
    "TerminalErrorDynamics",
    "TerminalErrorDynamicsState",
]
