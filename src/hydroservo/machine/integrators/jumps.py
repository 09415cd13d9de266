"""How near a jump an integrator asks for rates."""

# A few units in the last place, and more than the rounding of ops.at_or_after.
BEFORE = 1.0 - 2.0**-50
AFTER = 1.0 + 2.0**-50
