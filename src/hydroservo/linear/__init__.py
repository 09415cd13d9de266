"""What a loop is for small motions: the margins by which it is stable."""

from hydroservo.linear.margins import Margins, margins

__all__ = ["Margins", "margins"]
