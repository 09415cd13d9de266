"""Axes of ratios and of numbers that span decades, with ticks that are read as they stand."""

import math
from collections.abc import Sequence

from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

__all__ = ["plain_log", "spread_out"]

STEPS = (  # of ticks in a decade, coarser and coarser
    (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 9.5),
    (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0),
    (1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    (1.0, 2.0, 5.0),
    (1.0, 3.0),
    (1.0,),
)
MOST = 7  # ticks


def plain_log(axis: Axis, low: float, high: float, most: int = MOST) -> None:
    """Make an axis logarithmic, from ``low`` to ``high`` above 0, with few round ticks, written plainly."""
    axis.axes.set(**{f"{axis.axis_name}scale": "log", f"{axis.axis_name}lim": (low, high)})  # type: ignore[attr-defined]
    axis.set_major_locator(FixedLocator(round_ticks(low, high, most)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda tick, _: f"{tick:g}"))


def round_ticks(low: float, high: float, most: int) -> list[float]:
    """The finest of round steps that has no more ticks than so many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    found: list[float] = []
    for steps in STEPS:
        found = [float(f"{step}e{decade}") for decade in decades for step in steps]
        found = [tick for tick in found if low <= tick <= high]
        if len(found) <= most:
            break
    return found


def spread_out(wanted: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Positions in the order of those wanted and near them, but no nearer to each other than ``gap``.

    Args:
        wanted: where each would be alone.
        gap: between neighbours; less where so many have no room.
        low, high: the range that holds all.
    """
    if not wanted:
        return []
    order = sorted(range(len(wanted)), key=lambda index: wanted[index])
    gap = min(gap, (high - low) / max(len(wanted) - 1, 1))
    groups: list[tuple[list[int], float]] = []  # neighbours that touch, and the middle of each group
    for index in order:
        groups.append(([index], min(max(wanted[index], low), high)))
        while len(groups) > 1 and bottom(groups[-1], gap) < top(groups[-2], gap) + gap * (1.0 - 1e-9):
            members = groups[-2][0] + groups[-1][0]
            half = 0.5 * gap * (len(members) - 1)
            middle = math.fsum(wanted[one] for one in members) / len(members)
            groups[-2:] = [(members, min(max(middle, low + half), high - half))]
    places = [0.0] * len(wanted)
    for group in groups:
        for rank, index in enumerate(group[0]):
            places[index] = bottom(group, gap) + rank * gap
    return places


def bottom(group: tuple[list[int], float], gap: float) -> float:
    return group[1] - 0.5 * gap * (len(group[0]) - 1)


def top(group: tuple[list[int], float], gap: float) -> float:
    return group[1] + 0.5 * gap * (len(group[0]) - 1)
