"""What a law adds for a valve's overlap, and what is left of its command."""

from hydroservo.core.assumptions import Assumption, Facts, below
from hydroservo.core.errors import ParameterError


def check_overlaps(extend_overlap: float, retract_overlap: float, limit: float) -> None:
    """Refuse an overlap for which the largest command is added as a whole.

    Args:
        extend_overlap: command that passes it one way [V].
        retract_overlap: command that passes it the other way [V].
        limit: the largest command [V].

    Raises:
        ParameterError: nothing is left for the law.
    """
    for name, overlap in (("extend_overlap", extend_overlap), ("retract_overlap", retract_overlap)):
        if not overlap < limit:
            raise ParameterError(name, overlap, f"must be below saturation.limit, {limit:g} [V]")


def within_overlap(extend_overlap: float, retract_overlap: float, facts: Facts) -> Assumption:
    """That neither compensation [V] is more than the valve's overlap."""
    largest = max(extend_overlap, retract_overlap)
    meaning = "what is made up for is at most the valve's overlap"
    return below("overlap", meaning, largest, 1.0001 * facts.overlap, "V")
