"""How commands are held between samples."""

from hydroservo.control.holds.delayed import DelayedHold, DelayedHoldState, HeldTwice
from hydroservo.control.holds.zero_order import ZeroOrderHold, ZeroOrderHoldState

__all__ = ["DelayedHold", "DelayedHoldState", "HeldTwice", "ZeroOrderHold", "ZeroOrderHoldState"]
