"""One set of values that a search has tried."""

from collections.abc import Mapping
from typing import NamedTuple


class Tried(NamedTuple):
    """What one set of values does to the loops of a search.

    Attributes:
        parameters: the values by path, in SI units.
        error: weighted geometric mean of the loops' metric, in the metric's unit; inf where a run diverged.
        activity: likewise of the command's total variation [V]; nan where the loops do not have it.
        within: whether it keeps the bounds of the search.
    """

    parameters: Mapping[str, float]
    error: float
    activity: float
    within: bool

    def cost(self, effort: float) -> float:
        """The error, with a price on the activity: error activity^effort."""
        return self.error * (self.activity**effort if effort else 1.0)
