"""Figures of lettered panels: curves over a window of time, on ranges that spikes do not spoil."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hydroservo.figures.style import figure
from hydroservo.figures.words import quantity
from hydroservo.results import readable_unit

__all__ = ["WHOLE", "Curve", "Panel", "Samples", "Window", "panel_figure"]

Samples = NDArray[np.float64]

CLOSE_WIDTH = 1.2  # where curves are told apart by the panel's range
TAIL = 0.03  # of the samples may lie beyond either limit of a panel that leaves spikes out
MARGIN = 0.12  # of a panel's range, above and below
SAME_TIME = 1e-9  # [s]


class Window(NamedTuple):
    """The time that a panel shows."""

    title: str
    start: float  # [s]
    stop: float  # [s]
    zero: float = 0.0  # [s] what its axis counts from
    label: str = "time [s]"
    factor: float = 1.0  # from s to the axis
    dots: bool = False  # short enough to show samples


WHOLE = Window("whole run", 0.0, math.inf)


class Curve(NamedTuple):
    """A signal in SI units and how it is drawn."""

    label: str
    time: Samples
    values: Samples
    colour: str
    width: float = 1.1
    line: str = "-"
    steps: bool = False  # a signal that jumps at a sample and stays until the next


class Panel(NamedTuple):
    """Curves on common axes; the limits fit the curves named in ``fitted``, without their spikes."""

    quantity: str
    unit: str
    curves: Sequence[Curve]
    window: Window = WHOLE
    fitted: Sequence[str] = ()
    range_of: Window | None = None  # the time that the limits fit, if not the one shown


def panel_figure(panels: Sequence[Panel], mosaic: str, height: float) -> Figure:
    """A figure of lettered panels, with one legend above all of them.

    Args:
        panels: what to show in (a), (b) and so on.
        mosaic: where each letter lies, as matplotlib's ``subplot_mosaic`` reads it.
        height: of the figure, in inch.
    """
    fig = figure(height)
    axes = fig.subplot_mosaic(mosaic)
    for letter, panel in zip("abcdef", panels, strict=False):
        draw_panel(axes[letter], panel, letter)
    handles, labels = axes["a"].get_legend_handles_labels()
    if len(labels) > 1:
        fig.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    fig.align_ylabels()
    return fig


def draw_panel(axis: Axes, panel: Panel, letter: str) -> None:
    window = panel.window
    low, high = panel_limits(panel)
    unit, factor = axis_unit(panel.unit, max(abs(low), abs(high)))
    shown = [inside(curve, window) for curve in panel.curves]
    crowded = panel.fitted and len(shown) > 2
    for curve in shown:
        draw_curve(axis, curve._replace(width=CLOSE_WIDTH) if crowded else curve, window, factor)
    end = min(window.stop, max(float(curve.time[-1]) for curve in panel.curves))
    axis.set_xlim(window.factor * (window.start - window.zero), window.factor * (end - window.zero))
    axis.set_ylim(factor * low, factor * high)
    axis.set_xlabel(window.label)
    axis.set_ylabel(f"{panel.quantity} [{unit}]")
    axis.set_title(f"({letter}) {window.title}", loc="left", fontsize=8)
    note = clipped(shown, low, high, panel.unit) if window is WHOLE else ""
    axis.set_title(note, loc="right", fontsize=6, color="#555555")


def draw_curve(axis: Axes, curve: Curve, window: Window, factor: float) -> None:
    axis.plot(
        window.factor * (curve.time - window.zero),
        factor * curve.values,
        curve.line,
        color=curve.colour,
        linewidth=curve.width,
        label=curve.label,
        drawstyle="steps-post" if curve.steps else "default",
        marker="." if window.dots and not curve.steps else "",
        markersize=2.2,
    )


def panel_limits(panel: Panel) -> tuple[float, float]:
    window = panel.range_of or panel.window
    fitted = [curve for curve in panel.curves if curve.label in panel.fitted]
    tail = TAIL if fitted and window is WHOLE else 0.0
    return limits([inside(curve, window).values for curve in fitted or panel.curves], tail)


def inside(curve: Curve, window: Window) -> Curve:
    """The samples that a window shows; never the run's last, which lies on a jump of the square."""
    shown = (curve.time >= window.start - SAME_TIME) & (curve.time <= window.stop + SAME_TIME)
    shown[-1] = False
    return curve._replace(time=curve.time[shown], values=curve.values[shown])


def limits(curves: Sequence[Samples], tail: float) -> tuple[float, float]:
    """A range that holds all samples of all curves but a tail at either end of each, with a margin."""
    finite = [values[np.isfinite(values)] for values in curves]
    finite = [values for values in finite if values.size]
    if not finite:
        return -1.0, 1.0
    low = min(float(np.quantile(values, tail)) for values in finite)
    high = max(float(np.quantile(values, 1.0 - tail)) for values in finite)
    margin = MARGIN * (high - low) or MARGIN * abs(high) or 1.0
    return low - margin, high + margin


def axis_unit(unit: str, largest: float) -> tuple[str, float]:
    """The unit of an axis and the factor to it; powers of ten go into the unit, not onto the ticks."""
    label, factor = readable_unit(unit, largest)
    return (f"10⁻³ {label}", 1e3 * factor) if factor * largest < 0.01 else (label, factor)


def clipped(curves: Sequence[Curve], low: float, high: float, unit: str) -> str:
    """Which curves leave a panel and, where there is room to say, how far they reach."""
    reach = []
    for curve in curves:
        beyond = np.maximum(low - curve.values, curve.values - high)
        if np.any(beyond > 0.0):
            furthest = quantity(float(curve.values[np.nanargmax(beyond)]), unit)
            reach.append(curve.label if len(curves) > 2 else f"{curve.label} to {furthest}")
    return f"clipped: {', '.join(reach)}" if reach else ""
