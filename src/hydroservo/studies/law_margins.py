"""What a law's loop bears in small motions: the least of its margins over some operating points."""

import math
from collections.abc import Sequence
from functools import partial
from typing import Annotated, NamedTuple

import numpy as np

from hydroservo.audits.frozen import busiest, exact, frozen
from hydroservo.errors import HydroservoError
from hydroservo.field import Field
from hydroservo.linear import Margins, margins
from hydroservo.loop import Loop

DIGITS = 5  # that are kept: behind them processors differ in their linear algebra


class LawMargins(NamedTuple):
    """The least margins of a law over operating points, as :class:`~hydroservo.linear.Margins` has them.

    They are nan where the loop is unstable at one of these points, or linear at none.
    """

    points: Annotated[int, Field("", "operating points that were looked at")]
    linear: Annotated[int, Field("", "how many of them the loop is linear about")]
    stable: Annotated[bool, Field("", "whether there is one, and it is stable at all of these")]
    gain_margin: Annotated[float, Field("", "least factor above 1 by which the gain makes it unstable")]
    gain_reduction_margin: Annotated[float, Field("", "largest factor below 1 by which it does")]
    phase_margin: Annotated[float, Field("rad", "least phase that makes it unstable")]
    delay_margin: Annotated[float, Field("s", "least delay that makes it unstable")]
    disk_margin: Annotated[float, Field("", "alpha of the smallest of the symmetric disks")]
    sensitivity_peak: Annotated[float, Field("", "largest |S|")]
    nonlinear: Annotated[str, Field("", "why it is not about the first other point; or empty")]


def law_margins(loops: Sequence[Loop]) -> LawMargins:
    """The least margins of a law's loop, with its valve's lag, its sensors' and its hold's, as it samples.

    The points are the machine at rest under 0 V, and for each loop the instant at which its demand and load
    are largest together; :func:`~hydroservo.audits.frozen.frozen` says how the machine moves there.

    Args:
        loops: those of the law on one machine, such as one for each kind of demand.

    Fails as :func:`~hydroservo.linear.margins`: it says nothing of large motions, and between the points
    margins can be less.
    """
    looks = [partial(at_rest, loops[0]), *(partial(at_busiest, loop) for loop in loops)]
    found, why = [], []
    for look in looks:
        try:
            with np.errstate(all="ignore"):
                found.append(look())
        except (HydroservoError, ArithmeticError, np.linalg.LinAlgError) as error:
            why.append(str(error))
    return least(found)._replace(points=len(looks), nonlinear=why[0] if why else "")


def at_rest(loop: Loop) -> Margins:
    return margins(loop._replace(sensors=exact(loop.sensors)), command=0.0)


def at_busiest(loop: Loop) -> Margins:
    still = frozen(loop, busiest(loop))
    return margins(still.loop, command=still.command)


def least(found: Sequence[Margins]) -> LawMargins:
    """The least of each margin."""
    count, none = len(found), math.nan
    if not found or not all(one.stable for one in found):
        return LawMargins(count, count, False, none, none, none, none, none, none, "")
    return LawMargins(
        points=count,
        linear=count,
        stable=True,
        gain_margin=rounded(min(one.gain_margin for one in found)),
        gain_reduction_margin=rounded(max(one.gain_reduction_margin for one in found)),
        phase_margin=rounded(min(one.phase_margin for one in found)),
        delay_margin=rounded(min(one.delay_margin for one in found)),
        disk_margin=rounded(min(one.disk_margin for one in found)),
        sensitivity_peak=rounded(max(one.sensitivity_peak for one in found)),
        nonlinear="",
    )


def rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
