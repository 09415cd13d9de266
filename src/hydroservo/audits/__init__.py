"""What a law's theorem supposes, asked of a loop; what keeps its oscillation up; its chatter, foretold."""

from hydroservo.audits.audited import Asked, Audit, Strain, audit
from hydroservo.audits.chatter import Chatter, chatter
from hydroservo.audits.sustained import Sustained, sustained
from hydroservo.audits.tone import Swing, swing

__all__ = [
    "Asked",
    "Audit",
    "Chatter",
    "Strain",
    "Sustained",
    "Swing",
    "audit",
    "chatter",
    "sustained",
    "swing",
]
