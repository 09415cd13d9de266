"""How a law wants its error to vanish: what differs between most laws of relative degree two."""

from hydroservo.control.pulls.adaptive_super_twisting import AdaptiveSuperTwisting, AdaptiveSuperTwistingState
from hydroservo.control.pulls.explicit_reaching import ExplicitReaching
from hydroservo.control.pulls.homogeneous import HomogeneousPull, HomogeneousPullState
from hydroservo.control.pulls.implicit_reaching import ImplicitReaching
from hydroservo.control.pulls.linear import LinearPull, LinearPullState
from hydroservo.control.pulls.naive_super_twisting import NaiveSuperTwisting, NaiveSuperTwistingState
from hydroservo.control.pulls.nonsingular_terminal import (
    NonsingularTerminalPull,
    NonsingularTerminalPullState,
)
from hydroservo.control.pulls.rise import RISEPull, RISEPullState
from hydroservo.control.pulls.smooth_reaching import SmoothReaching
from hydroservo.control.pulls.super_twisting import SuperTwisting, SuperTwistingState
from hydroservo.control.pulls.terminal import TerminalPull, TerminalPullState

__all__ = [
    "AdaptiveSuperTwisting",
    "AdaptiveSuperTwistingState",
    "ExplicitReaching",
    "HomogeneousPull",
    "HomogeneousPullState",
    "ImplicitReaching",
    "LinearPull",
    "LinearPullState",
    "NaiveSuperTwisting",
    "NaiveSuperTwistingState",
    "NonsingularTerminalPull",
    "NonsingularTerminalPullState",
    "RISEPull",
    "RISEPullState",
    "SmoothReaching",
    "SuperTwisting",
    "SuperTwistingState",
    "TerminalPull",
    "TerminalPullState",
]
