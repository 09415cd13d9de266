"""What a law's theorem supposes, asked of a loop; what keeps its oscillation up; its chatter, foretold."""

from hydroservo.audits.audit import Audit, BlockAssumptions, Strain, audit
from hydroservo.audits.chatter import Chatter, chatter
from hydroservo.audits.monitors import Swing, swing
from hydroservo.audits.oscillation import SustainedOscillation, sustained_oscillation

__all__ = [
    "Audit",
    "BlockAssumptions",
    "Chatter",
    "Strain",
    "SustainedOscillation",
    "Swing",
    "audit",
    "chatter",
    "sustained_oscillation",
    "swing",
]
