"""The arithmetic of one step of a unit."""

from typing import Annotated, NamedTuple

from hydroservo.field import Field


class Operations(NamedTuple):
    """What a step takes of arithmetic with real numbers at most: of ways that part, the dearer one.

    Changes of sign, absolute values, and arithmetic with whole numbers and bits, are not counted. What
    functions of ``ops`` such as a power take is in the other numbers too.
    """

    additions: Annotated[int, Field("", "additions and subtractions")] = 0
    multiplications: Annotated[int, Field("", "multiplications")] = 0
    divisions: Annotated[int, Field("", "divisions")] = 0
    roots: Annotated[int, Field("", "square roots")] = 0
    comparisons: Annotated[int, Field("", "comparisons")] = 0
    functions: Annotated[int, Field("", "calls of powers, exponentials, sines and their like")] = 0

    @property
    def total(self) -> int:
        """All of them; what functions take counts once."""
        return sum(self[:5])

    def plus(self, other: "Operations") -> "Operations":
        """Both, one after the other."""
        return Operations(*(a + b for a, b in zip(self, other, strict=True)))

    def times(self, count: int) -> "Operations":
        """So many times."""
        return Operations(*(count * a for a in self))
