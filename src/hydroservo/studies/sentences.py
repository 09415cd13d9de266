"""Verdicts in words."""

import math

from hydroservo.studies.best import Best

__all__ = ["sentence"]


def sentence(best: Best) -> str:
    """Who wins a cell, and how surely."""
    if best.state == "none":
        return "none: each law loses too many runs"
    others = [law for law in best.ties if law != best.law]
    tied = f" ties with {', '.join(others)}" if others else ""
    if best.state == "tie":
        return f"tie: {best.law}{tied}"
    if math.isnan(best.margin):
        return f"{best.law} wins{tied and ','}{tied}; no other family runs"
    if best.margin < 1.0:
        return f"{best.law} wins{tied and ','}{tied}: {best.next_family} loses more runs"
    interval = f"{best.margin_low:.2f} to {best.margin_high:.2f}"
    ahead = f"the next family's {best.next_family} has {best.margin:.2f} times its error ({interval})"
    return f"{best.law} wins{tied and ','}{tied}; {ahead}"
