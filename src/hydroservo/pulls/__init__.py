"""How a law wants its error to vanish: what differs between most laws of relative degree two."""

from hydroservo.pulls.adaptive_super_twisting import AdaptiveSuperTwisting, AdaptiveSuperTwistingState
from hydroservo.pulls.explicit_reaching import ExplicitReaching
from hydroservo.pulls.homogeneous import HomogeneousPull, HomogeneousPullState
from hydroservo.pulls.implicit_reaching import ImplicitReaching
from hydroservo.pulls.linear import LinearPull, LinearPullState
from hydroservo.pulls.naive_super_twisting import NaiveSuperTwisting, NaiveSuperTwistingState
from hydroservo.pulls.nonsingular_terminal import NonsingularTerminalPull, NonsingularTerminalPullState
from hydroservo.pulls.rise import RISEPull, RISEPullState
from hydroservo.pulls.smooth_reaching import SmoothReaching
from hydroservo.pulls.super_twisting import SuperTwisting, SuperTwistingState
from hydroservo.pulls.terminal import TerminalPull, TerminalPullState

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
