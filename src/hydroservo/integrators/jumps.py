"""How near a jump an integrator's step may come."""

__all__ = ["AFTER", "AT_END", "BEFORE"]

BEFORE = 1.0 - 2.0**-50  # a few units in the last place before a jump
AFTER = 1.0 + 2.0**-50
AT_END = 1.0 - 2e-9  # a jump this close to the end of a step counts as there, as loads count it
