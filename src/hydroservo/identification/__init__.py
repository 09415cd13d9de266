"""Parameters of a machine, and how sure they are, from logs of it."""

from hydroservo.identification.identified import identify
from hydroservo.identification.result import Estimate, Identified, LogFit, SignalFit

__all__ = ["Estimate", "Identified", "LogFit", "SignalFit", "identify"]
