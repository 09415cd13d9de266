"""Rules of MISRA C:2012 that exported C does not follow, by number, and why."""

__all__ = ["DEVIATIONS"]

DEVIATIONS = {
    "12.1": "Sums of products are written as in the equations, without parentheses that these do not have.",
}
