"""Parameters of a machine, and how sure they are, from logs of it."""

from hydroservo.identification.conclusions import Comparison, compare
from hydroservo.identification.effects import LeftOutEffect
from hydroservo.identification.identify import identify
from hydroservo.identification.proposal import Promise, Proposal, propose
from hydroservo.identification.result import Estimate, Identified, LogFit, SignalFit

__all__ = [
    "Comparison",
    "Estimate",
    "Identified",
    "LeftOutEffect",
    "LogFit",
    "Promise",
    "Proposal",
    "SignalFit",
    "compare",
    "identify",
    "propose",
]
