"""What error costs in command activity: the front of a cell."""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hydroservo.figures.studies.looks import INK, SOFT, family_colours
from hydroservo.figures.studies.names import Named, name_points
from hydroservo.figures.studies.scales import plain_log
from hydroservo.figures.style import figure, style
from hydroservo.formatting import TIMES, readable_unit

__all__ = ["FrontPoint", "plot_front", "staircase"]

UNKNOWN, LEAST, GROWTH = 3.0, 3.5, 1.9  # points: a mark's size, and how it grows from scale to scale
MARGIN = 1.25  # about the points
FADED = 0.35


class FrontPoint(NamedTuple):
    """A law with the gains of one effort."""

    law: str
    family: str
    error: float  # [unit of the metric]
    activity: float  # total variation of the command [%/s]
    scale: float  # the largest multiple of the nominal uncertainty without a lost run; nan where not tried
    front: bool  # no other point is better in one of these three and as good in the others


def plot_front(points: Sequence[FrontPoint], families: Sequence[str], metric: str, unit: str) -> Figure:
    """Error against command activity; the larger a mark the more robust. The front's members are named.

    A line shows the least error that is to be had for each activity; members of the front above it are there
    for what they survive.

    Args:
        points: of one cell, with finite error and activity.
        families: all of the study, in the order that gives them their colours.
        metric: what the error is.
        unit: of the error.
    """
    colours = family_colours(families)
    label, factor = readable_unit(unit, max(point.error for point in points))
    scales = sorted({point.scale for point in points if not math.isnan(point.scale)})
    front = sorted((point for point in points if point.front), key=lambda point: point.activity)
    steps = staircase((point.activity, factor * point.error) for point in points)
    with style(maths=False):
        fig = figure(3.9)
        axis = fig.subplots()
        set_ranges(axis, points, factor)
        axis.plot(*zip(*steps, strict=True), color=SOFT, linewidth=0.8, zorder=1)
        for point in points:
            draw_point(axis, point, colours[point.family], scales, factor)
        axis.set_xlabel("command activity [% of its range per second]")
        axis.set_ylabel(f"{metric} [{label}]")
        shown = [family for family in colours if any(point.family == family for point in points)]
        hues = [Line2D([], [], marker="o", linestyle="", color=colours[one], label=one) for one in shown]
        fig.legend(handles=[*hues, *sizes(scales)], loc="outside right upper", labelspacing=0.7)
        named = [Named(one.law, one.activity, factor * one.error, INK) for one in front]
        others = [(one.activity, factor * one.error) for one in points if not one.front]
        name_points(fig, axis, named, others, steps)
    return fig


def staircase(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """The corners of the least error that is to be had for each price, from points (price, error)."""
    found: list[tuple[float, float]] = []
    for price, error in sorted(points):
        if not found:
            found.append((price, error))
        elif error < found[-1][1]:
            found += [(price, found[-1][1]), (price, error)]
    return found


def set_ranges(axis: Axes, points: Sequence[FrontPoint], factor: float) -> None:
    activity = [point.activity for point in points]
    error = [factor * point.error for point in points]
    plain_log(axis.xaxis, min(activity) / MARGIN, max(activity) * MARGIN)
    plain_log(axis.yaxis, min(error) / MARGIN**0.5, max(error) * MARGIN**0.5)


def draw_point(axis: Axes, point: FrontPoint, colour: str, scales: Sequence[float], factor: float) -> None:
    (mark,) = axis.plot(
        point.activity, factor * point.error, "o", color=colour, zorder=3 if point.front else 2
    )
    mark.set(markersize=size(point.scale, scales), markeredgecolor="white", markeredgewidth=0.5)
    mark.set_alpha(1.0 if point.front else FADED)


def size(scale: float, scales: Sequence[float]) -> float:
    """Of a mark, in points."""
    return UNKNOWN if math.isnan(scale) else LEAST + GROWTH * scales.index(scale)


def sizes(scales: Sequence[float]) -> list[Line2D]:
    """What the sizes mean."""
    if not scales:
        return []
    heading = Line2D([], [], linestyle="", label="survives uncertainty of")
    found = [
        Line2D([], [], marker="o", linestyle="", color=SOFT, label=f"{scale:g} {TIMES} nominal")
        for scale in scales
    ]
    for mark, scale in zip(found, scales, strict=True):
        mark.set_markersize(size(scale, scales))
    return [heading, *found]
