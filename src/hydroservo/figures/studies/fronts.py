"""What error costs: in command activity, the fronts of laws, and on the target in operations a sample."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from hydroservo.core.formatting import quantity, readable_unit
from hydroservo.figures.studies import looks
from hydroservo.figures.style import Plot, figure, style

ACROSS = 4  # panels in a row
HEIGHT, ALONE = 1.75, 2.6  # inch, of a panel: of several rows, and of one
KEY = 0.9  # inch, of what is below
WORST = 1.35  # times the reference's error, up to which fronts are shown
MARGIN = 1.15  # about the levels and the least error
PALE = "#c9d1d8"
RatioInterval = tuple[float, float, float]  # value, low, high
SIZE = 5.5  # points
ABOUT_POINTS = 1.4  # about the points
KINDS = {"linear": "with margins", "rough": "not linear", "unstable": "unstable"}
FILLS = {"linear": "full", "rough": "none", "unstable": "none"}
MARKS = {"linear": "o", "rough": "o", "unstable": "X"}


class FrontLine(NamedTuple):
    """The front of a law."""

    law: str
    activity: Sequence[float]  # over that of the reference, rising
    error: Sequence[
        RatioInterval
    ]  # over that of the reference at its own activity, falling, with its interval
    taken: Sequence[tuple[float, float]]  # activity and error of the points that are compared


class FrontPanel(NamedTuple):
    """The fronts of a cell."""

    title: str
    error: float  # of the reference at its own activity [unit of the metric]
    activity: float  # its own [%/s]
    lines: Sequence[FrontLine]


def plot_fronts(
    panels: Sequence[FrontPanel], named: Sequence[str], reference: str, levels: Sequence[float], unit: str
) -> Plot:
    """Error over command activity, both over the reference's; bands are intervals of named laws.

    Dots are the points at which laws are compared.
    """
    colours = dict(zip(named, cycle(looks.FAMILIES), strict=False)) | {reference: looks.INK}
    across = min(ACROSS, len(panels))
    down = -(-len(panels) // across)
    errors = [ratio[0] for panel in panels for line in panel.lines for ratio in line.error]
    least = min([1.0, *(one for one in errors if one > 0.0)])
    pale = any(line.law not in colours for panel in panels for line in panel.lines)
    with style(maths=False):
        fig = figure((HEIGHT if down > 1 else ALONE) * down + KEY)
        axes = fig.subplots(down, across, sharex=True, sharey=True, squeeze=False)
        for axis, panel in zip(axes.flat, panels, strict=False):
            looks.plain_log(axis.xaxis, levels[0] / MARGIN, levels[-1] * MARGIN)
            looks.plain_log(axis.yaxis, least / MARGIN**0.3, WORST)
            axis.axhline(1.0, color=looks.SOFT, linewidth=0.6, zorder=1)
            draw_lines(axis, panel.lines, colours)
            about = f"{quantity(panel.error, unit)} at {panel.activity:.2g} %/s"
            axis.set_title(f"{panel.title}\n{about}", fontsize=7.5, loc="left", linespacing=1.3)
        for axis in axes.flat[len(panels) :]:
            axis.set_axis_off()
        for axis in axes.flat[max(len(panels) - across, 0) : len(panels)]:
            axis.tick_params(labelbottom=True)
            axis.set_xlabel(f"activity over {reference}'s")
        for axis in axes[:, 0]:
            axis.set_ylabel(f"error over {reference}'s")
        fig.legend(handles=front_key(colours, pale), loc="outside lower center", ncols=4)
        looks.fix_layout(fig)
    return fig


def draw_lines(axis: Axes, lines: Sequence[FrontLine], colours: Mapping[str, str]) -> None:
    """The fronts of a cell, the pale ones below."""
    for line in sorted(lines, key=lambda one: one.law in colours):
        colour = colours.get(line.law, PALE)
        value, low, high = zip(*line.error, strict=True)
        strong = line.law in colours
        axis.plot(line.activity, value, color=colour, linewidth=1.2 if strong else 0.6, zorder=2 + strong)
        if strong:
            for activity, error in line.taken:
                axis.plot(activity, error, ".", color=colour, markersize=4, zorder=4)
            axis.fill_between(line.activity, low, high, color=colour, alpha=0.15, linewidth=0, zorder=2)


def front_key(colours: Mapping[str, str], pale: bool) -> list[Line2D]:
    own = [Line2D([], [], color=colour, linewidth=1.2, label=law) for law, colour in colours.items()]
    return [*own, Line2D([], [], color=PALE, linewidth=0.8, label="other laws")] if pale else own


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
    """
    colours = looks.family_colours(families)
    label, factor = readable_unit(unit, max(point.error for point in points))
    errors, operations = [factor * point.error for point in points], [point.operations for point in points]
    steps = staircase(zip(operations, errors, strict=True))
    with style(maths=False):
        fig = figure(3.9)
        axis = fig.subplots()
        looks.plain_log(axis.xaxis, min(operations) / ABOUT_POINTS, max(operations) * ABOUT_POINTS)
        looks.plain_log(axis.yaxis, min(errors) / ABOUT_POINTS**0.5, max(errors) * ABOUT_POINTS**0.5)
        axis.plot(*zip(*steps, strict=True), color=looks.SOFT, linewidth=0.8, zorder=1)
        for point, error in zip(points, errors, strict=True):
            axis.add_line(kind_mark(point.kind, colours[point.family], point.operations, error))
        axis.set_xlabel("operations with real numbers a sample, at most")
        axis.set_ylabel(f"{metric} [{label}]")
        fig.legend(handles=key_of_kinds(points, colours), loc="outside right upper", labelspacing=0.7)
        names = [looks.NamedPoint(one.law, one.operations, factor * one.error, looks.INK) for one in points]
        looks.name_points(fig, axis, names, [], steps)
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


def kind_mark(kind: str, colour: str, x: float, y: float) -> Line2D:
    found = Line2D([x], [y], linestyle="", color=colour, zorder=3)
    found.set(marker=MARKS[kind], fillstyle=FILLS[kind], markersize=SIZE, markeredgewidth=1.2)
    return found


def key_of_kinds(points: Sequence[TargetPoint], colours: dict[str, str]) -> list[Line2D]:
    """What colours and marks mean, as far as they are there."""
    shown = [family for family in colours if any(point.family == family for point in points)]
    hues = [Line2D([], [], marker="o", linestyle="", color=colours[one], label=one) for one in shown]
    kinds = [kind for kind in KINDS if any(point.kind == kind for point in points)]
    marks = [kind_mark(kind, looks.SOFT, 0.0, 0.0) for kind in kinds]
    for one, kind in zip(marks, kinds, strict=True):
        one.set_label(KINDS[kind])
    return [*hues, Line2D([], [], linestyle="", label="in small motions"), *marks]
