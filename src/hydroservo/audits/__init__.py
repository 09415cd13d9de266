"""What a law's theorem supposes, asked of a loop; what keeps its oscillation up; its chatter, foretold."""

from hydroservo.audits.audited import Audit, audit
from hydroservo.audits.auditor import Asked
from hydroservo.audits.chatter import Chatter, chatter
from hydroservo.audits.strain import Strain
from hydroservo.audits.sustained import Sustained, sustained
from hydroservo.audits.swing import Swing, swing

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
