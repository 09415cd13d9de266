"""Parameters of a machine, and how sure they are, from logs of it."""

from hydroservo.identification.comparison import Comparison, compare
from hydroservo.identification.identified import identify
from hydroservo.identification.left_out import Effect
from hydroservo.identification.proposal import Promise, Proposal, propose
from hydroservo.identification.result import Estimate, Identified, LogFit, SignalFit

__all__ = [
    "Comparison",
    "Effect",
    "Estimate",
    "Identified",
    "LogFit",
    "Promise",
    "Proposal",
    "SignalFit",
    "compare",
    "identify",
    "propose",
]
