"""What a law's theorem supposes, asked of a loop; and its chatter, foretold."""

from hydroservo.audits.audited import Audit, audit
from hydroservo.audits.auditor import Asked
from hydroservo.audits.chatter import Chatter, chatter
from hydroservo.audits.swing import Swing, swing

__all__ = ["Asked", "Audit", "Chatter", "Swing", "audit", "chatter", "swing"]
