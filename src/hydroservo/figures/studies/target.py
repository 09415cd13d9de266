"""What error costs on the target: error against operations a sample."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from matplotlib.lines import Line2D

from hydroservo.figures.studies.looks import INK, SOFT, family_colours, plain_log
from hydroservo.figures.studies.names import Named, name_points
from hydroservo.figures.style import Plot, figure, style
from hydroservo.formatting import readable_unit

SIZE = 5.5  # points
MARGIN = 1.4  # about the points
KINDS = {"linear": "with margins", "rough": "not linear", "unstable": "unstable"}
FILLS = {"linear": "full", "rough": "none", "unstable": "none"}
MARKS = {"linear": "o", "rough": "o", "unstable": "X"}


class TargetPoint(NamedTuple):
    """A law in a cell."""

    law: str
    family: str
    error: float  # [unit of the metric]
    operations: float  # with real numbers, a sample
    kind: str  # in small motions: of KINDS


def plot_target(points: Sequence[TargetPoint], families: Sequence[str], metric: str, unit: str) -> Plot:
    """Error against operations a sample; hollow marks are of laws that have no margins.

    A line shows the least error that is to be had for so many operations.

    Args:
        points: of one cell, with finite errors.
        families: all of the study, in the order that gives them their colours.
        metric: what the error is.
        unit: of the error.
    """
    colours = family_colours(families)
    label, factor = readable_unit(unit, max(point.error for point in points))
    errors, operations = [factor * point.error for point in points], [point.operations for point in points]
    steps = staircase(zip(operations, errors, strict=True))
    with style(maths=False):
        fig = figure(3.9)
        axis = fig.subplots()
        plain_log(axis.xaxis, min(operations) / MARGIN, max(operations) * MARGIN)
        plain_log(axis.yaxis, min(errors) / MARGIN**0.5, max(errors) * MARGIN**0.5)
        axis.plot(*zip(*steps, strict=True), color=SOFT, linewidth=0.8, zorder=1)
        for point, error in zip(points, errors, strict=True):
            axis.add_line(mark(point.kind, colours[point.family], point.operations, error))
        axis.set_xlabel("operations with real numbers a sample, at most")
        axis.set_ylabel(f"{metric} [{label}]")
        fig.legend(handles=key(points, colours), loc="outside right upper", labelspacing=0.7)
        names = [Named(one.law, one.operations, factor * one.error, INK) for one in points]
        name_points(fig, axis, names, [], steps)
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


def mark(kind: str, colour: str, x: float, y: float) -> Line2D:
    found = Line2D([x], [y], linestyle="", color=colour, zorder=3)
    found.set(marker=MARKS[kind], fillstyle=FILLS[kind], markersize=SIZE, markeredgewidth=1.2)
    return found


def key(points: Sequence[TargetPoint], colours: dict[str, str]) -> list[Line2D]:
    """What colours and marks mean, as far as they are there."""
    shown = [family for family in colours if any(point.family == family for point in points)]
    hues = [Line2D([], [], marker="o", linestyle="", color=colours[one], label=one) for one in shown]
    kinds = [kind for kind in KINDS if any(point.kind == kind for point in points)]
    marks = [mark(kind, SOFT, 0.0, 0.0) for kind in kinds]
    for one, kind in zip(marks, kinds, strict=True):
        one.set_label(KINDS[kind])
    return [*hues, Line2D([], [], linestyle="", label="in small motions"), *marks]
