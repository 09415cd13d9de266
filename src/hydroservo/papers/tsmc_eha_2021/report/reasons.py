"""Each verdict in words: which run decides a claim, what was measured in it and what is allowed."""

from typing import Self

from hydroservo.field import Field
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.papers.tsmc_eha_2021.claims import Claim, Outcome, Results
from hydroservo.papers.tsmc_eha_2021.report.names import NAMES, run_name
from hydroservo.readable import number, quantity

__all__ = ["worst_case"]

SETTLED = {
    "error": Field("m/s", "largest velocity error once settled"),
    "s1": Field("m/s", "largest |s1| once settled"),
    "s2": Field("N", "largest |s2| once settled"),
    "xi1": Field("m/s", "largest |xi1| once settled"),
    "xi2": Field("m/s^2", "largest |xi2| once settled"),
    "miss1": Field("m/s^2", "largest error of the estimate of d_L1 once settled"),
    "miss2": Field("N/s", "largest error of the estimate of d_L2 once settled"),
}


class Sourced(float):
    """A number that knows where it came from.

    A claim divides what was measured by what it allows; done with such numbers, the ratio can say what it
    is made of, and words and verdict cannot disagree.
    """

    demand: str
    controller: str
    field: Field

    def __new__(cls, value: float, key: tuple[str, str], field: Field) -> Self:
        made = super().__new__(cls, value)
        made.demand, made.controller = key
        made.field = field
        return made

    def __truediv__(self, other: float) -> "SourcedRatio":
        return SourcedRatio(self, other)


class SourcedRatio(float):
    """A ratio that knows its two numbers."""

    measured: Sourced
    allowed: float

    def __new__(cls, measured: Sourced, allowed: float) -> Self:
        made = super().__new__(cls, float(measured) / float(allowed))
        made.measured, made.allowed = measured, allowed
        return made


def worst_case(claim: Claim, results: Results) -> str:
    """What decides a claim under one condition: its worst run, what was measured and what is allowed."""
    ratio = claim.ratio({key: sourced(key, run) for key, run in results.items()})
    if not isinstance(ratio, SourcedRatio):
        return without_numbers(ratio, results)
    measured, allowed = ratio.measured, ratio.allowed
    unit = measured.field.unit
    limit = quantity(allowed, unit)
    against = (
        f"{NAMES[allowed.controller]}'s {limit}" if isinstance(allowed, Sourced) else f"the {limit} allowed"
    )
    digits = 5 if abs(ratio - 1.0) < 0.005 else 3  # enough to tell a ratio from 1
    return (
        f"{run_name(measured.demand, measured.controller)}: {quantity(measured, unit)} "
        f"({measured.field.meaning}), {number(ratio, digits)} times {against}"
    )


def sourced(key: tuple[str, str], run: Outcome) -> Outcome:
    """An outcome whose numbers know where they came from."""
    return Outcome(
        {name: Sourced(value, key, METRIC_FIELDS[name]) for name, value in run.metrics.items()},
        {name: Sourced(value, key, SETTLED[name]) for name, value in run.settled.items()},
    )


def without_numbers(ratio: float, results: Results) -> str:
    """Why a ratio is zero or infinite."""
    lost = [run_name(*key) for key, run in results.items() if run.metrics["diverged"]]
    if not lost:
        return "no finite ratio: a number is missing, or the rival's is 0"
    return f"{', '.join(lost)} diverged" + (", so no rival is left" if ratio == 0.0 else "")
