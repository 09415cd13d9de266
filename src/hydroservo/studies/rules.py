"""What a comparison goes by: how sure, how much, how many."""

from typing import NamedTuple

from hydroservo.errors import ParameterError


class Rules(NamedTuple):
    """The numbers of a fair comparison, the same for all laws and cells.

    Attributes:
        confidence: of intervals, and 1 less the level of Holm's correction.
        margin: a ratio of errors nearer to 1 than this one counts as a tie, however sure it is.
        most_lost: a law that loses a greater share of its test runs is out of the running in that cell.
        near_best: a law whose error is below so many times the best one's is near it.
        worst: the share of conditions over which the mean of the worst is taken.
        resamples: of the bootstrap, for shares of factors.
        seed: of the bootstrap.
    """

    confidence: float = 0.95
    margin: float = 1.05
    most_lost: float = 0.1
    near_best: float = 1.1
    worst: float = 0.1
    resamples: int = 10_000
    seed: int = 0


def checked_rules(rules: Rules) -> Rules:
    """Rules that can be gone by."""
    for name in ("confidence", "worst"):
        if not 0.0 < getattr(rules, name) < 1.0:
            raise ParameterError(f"rules.{name}", getattr(rules, name), "must lie between 0 and 1")
    for name in ("margin", "near_best"):
        if not getattr(rules, name) >= 1.0:
            raise ParameterError(f"rules.{name}", getattr(rules, name), "must be 1 or more")
    if not 0.0 <= rules.most_lost < 1.0:
        raise ParameterError("rules.most_lost", rules.most_lost, "must be 0 or more, and below 1")
    if rules.resamples < 1:
        raise ParameterError("rules.resamples", rules.resamples, "must be 1 or more")
    if not 0 <= rules.seed < 2**64:
        raise ParameterError("rules.seed", rules.seed, "must lie in 0..2^64-1")
    return rules
