"""The signals of a run that plots show, and panels of them on ranges that spikes do not spoil."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from hydroservo.core.errors import HydroservoError
from hydroservo.core.formatting import quantity, readable_unit
from hydroservo.figures.style import GREY, Plot, figure
from hydroservo.runs.cautions.run import Unrecorded, unrecorded_command
from hydroservo.runs.results import scenario_tables

Samples = NDArray[np.float64]
CONTROLLED = "controlled.value"
CLOSE_WIDTH = 1.2  # where curves are told apart by the panel's range
TAIL = 0.03  # of the samples may lie beyond either limit of a panel that leaves spikes out
FLAT = 15.0  # a curve this many times below the highest peak is pressed flat
FLATTEST = 1e5  # and this many times below it, is nothing but rounding
LARGEST_VECTOR = 20_000  # points; a longer curve becomes pixels inside an SVG, which would else be huge
MOSTLY = 0.5  # of its samples
SAME_TIME = 1e-9  # [s]

MARGIN = 0.12  # of a range, above and below
SMALLER = {"mm": "µm", "mm/s": "µm/s", "mV": "µV", "mA": "µA"}  # by a factor of 1000


class PlottedRun(NamedTuple):
    """What a plot shows of a run, in SI units; a diverged run ends where it was lost."""

    time: Samples
    demand: Samples
    signal: Samples  # that the loop controls
    error: Samples  # demand less signal
    command: Samples
    disturbances: tuple[Samples, ...]  # d_L1 [m/s^2] and d_L2 [N/s]
    estimates: tuple[Samples, ...]  # of both; empty without an observer
    diverged: bool
    unrecorded: Unrecorded = Unrecorded()
    name: str = "velocity"  # of the controlled signal
    unit: str = "m/s"  # of it
    pressures: Mapping[str, Samples] = {}  # in both chambers, and of the supply where it is known; by name


def trace_of(dataset: xr.Dataset) -> PlottedRun:
    """The signals that plots show."""
    missing = [path for path in (CONTROLLED, "reference.value", "controller.u") if path not in dataset]
    if missing:
        raise HydroservoError(f"a plot needs {', '.join(missing)}, which this run did not record")
    demand, signal = dataset["reference.value"].values, dataset[CONTROLLED].values
    diverged = bool(dataset["diverged"])
    end = length_shown(signal) if diverged else demand.size
    truths, estimates = (
        disturbance_pair(dataset, "disturbance"),
        disturbance_pair(dataset, observer_path(dataset)),
    )
    both = bool(truths and estimates)
    return PlottedRun(
        time=dataset["time"].values[:end],
        demand=demand[:end],
        signal=signal[:end],
        error=(demand - signal)[:end],
        command=dataset["controller.u"].values[:end],
        disturbances=tuple(values[:end] for values in truths if both),
        estimates=tuple(values[:end] for values in estimates if both),
        diverged=diverged,
        unrecorded=unrecorded_command(dataset, scenario_tables(dataset)["simulation"]["period"]),
        name=dataset[CONTROLLED].attrs.get("long_name", ""),
        unit=dataset[CONTROLLED].attrs.get("units", ""),
        pressures={name: values[:end] for name, values in pressure_signals(dataset).items()},
    )


def pressure_signals(dataset: xr.Dataset) -> dict[str, Samples]:
    """The gauge pressures in the chambers and of the supply; empty where the chambers were not recorded."""
    chambers = {"chamber A": "plant.pressure_a", "chamber B": "plant.pressure_b"}
    if not set(chambers.values()) <= set(dataset.data_vars):
        return {}
    found = {name: dataset[path].values for name, path in chambers.items()}
    given = scenario_tables(dataset)["supply"].get("supply_pressure")
    if "supply.pressure" in dataset:
        found["supply"] = dataset["supply.pressure"].values
    elif given is not None:
        found["supply"] = np.full(dataset["time"].size, float(given))
    return found


def length_shown(signal: Samples) -> int:
    """How many samples of a diverged run come before it was lost; at least two."""
    lost = ~np.isfinite(signal)
    return max(int(np.argmax(lost)) if lost.any() else signal.size, 2)


def observer_path(dataset: xr.Dataset) -> str:
    """The path of the first part of the controller that holds two estimates d1 and d2; "" without one."""
    names = (str(name) for name in dataset.data_vars)
    holders = (name.removesuffix(".d1") for name in names if re.fullmatch(r"controller\..*\bd1", name))
    return next((one for one in holders if f"{one}.d2" in dataset), "")


def disturbance_pair(dataset: xr.Dataset, path: str) -> tuple[Samples, ...]:
    """The signals d1 and d2 at a path; nothing unless both were recorded."""
    names = (f"{path}.d1", f"{path}.d2")
    return tuple(dataset[name].values for name in names) if set(names) <= set(dataset.data_vars) else ()


class TimeWindow(NamedTuple):
    """The time that a panel shows."""

    title: str
    start: float  # [s]
    stop: float  # [s]
    zero: float = 0.0  # [s] what its axis counts from
    label: str = "time [s]"
    factor: float = 1.0  # from s to the axis
    dots: bool = False  # short enough to show samples
    whole: bool = False  # so long that spikes would spoil its range


WHOLE = TimeWindow("whole run", 0.0, math.inf, whole=True)


class SignalCurve(NamedTuple):
    """A signal in SI units and how it is drawn."""

    label: str
    time: Samples
    values: Samples
    colour: str
    width: float = 1.1  # points
    line: str = "-"
    steps: bool = False  # a signal that jumps at a sample and stays until the next


class Panel(NamedTuple):
    """Curves on common axes; the limits fit the curves named in ``fitted``, without their spikes."""

    quantity: str
    unit: str
    curves: Sequence[SignalCurve]
    window: TimeWindow = WHOLE
    fitted: Sequence[str] = ()
    range_of: TimeWindow | None = None  # the time that the limits fit, if not the one shown
    zero: bool = False  # the limits hold zero


def panel_figure(panels: Sequence[Panel], mosaic: str, height: float) -> Plot:
    """A figure of lettered panels, with one legend above all of them."""
    fig = figure(height)
    axes = fig.subplot_mosaic(mosaic)
    for letter, panel in zip("abcdef", panels, strict=False):
        axis = axes[letter]
        draw_panel(axis, panel)
        axis.set_xlabel(panel.window.label)
        axis.set_title(f"({letter}) {panel.window.title}", loc="left", fontsize=8)
        axis.set_title(clipped_text(panel), loc="right", fontsize=6, color=GREY)
    handles, labels = axes["a"].get_legend_handles_labels()
    if len(labels) > 1:
        fig.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    fig.align_ylabels()
    return fig


def draw_panel(axis: Axes, panel: Panel) -> None:
    """Draw the curves of a panel, set its ranges and name its quantity and unit."""
    window = panel.window
    low, high = panel_limits(panel)
    unit, factor = axis_unit(panel.unit, max(abs(low), abs(high)))
    crowded = panel.fitted and len(panel.curves) > 2
    for curve in panel.curves:
        draw_curve(axis, curve._replace(width=CLOSE_WIDTH) if crowded else curve, window, factor)
    if math.isfinite(window.stop):
        axis.set_xlim(
            window.factor * (window.start - window.zero), window.factor * (window.stop - window.zero)
        )
    axis.set_ylim(factor * low, factor * high)
    axis.set_ylabel(f"{panel.quantity} [{unit}]")


def draw_curve(axis: Axes, curve: SignalCurve, window: TimeWindow, factor: float) -> None:
    shown = curve_inside(curve, window)
    axis.plot(
        window.factor * (shown.time - window.zero),
        factor * shown.values,
        curve.line,
        color=curve.colour,
        linewidth=curve.width,
        label=curve.label or None,
        drawstyle="steps-post" if curve.steps else "default",
        marker="." if window.dots and not curve.steps else "",
        markersize=2.2,
        rasterized=shown.time.size > LARGEST_VECTOR,
    )


def panel_limits(panel: Panel) -> tuple[float, float]:
    """The range of a panel, in SI units."""
    window = panel.range_of or panel.window
    fitted = [curve for curve in panel.curves if curve.label in panel.fitted]
    tail = TAIL if fitted and window.whole else 0.0
    values = [curve_inside(curve, window).values for curve in fitted or panel.curves]
    return range_with_margin([*values, np.zeros(1)] if panel.zero else values, tail)


def enlarged_panels(panel: Panel) -> list[Panel]:
    """The panel again on the range of the curves that short peaks or another curve press flat, if any.

    And once more for what these press flat in their turn, so that each curve is seen in some panel.
    """
    sizes = {curve.label: largest_size([curve.values], TAIL) for curve in panel.curves}
    highest = largest_size([curve.values for curve in panel.curves])
    sizes = {label: size for label, size in sizes.items() if size > highest / FLATTEST}
    panels = []
    while sizes := {label: size for label, size in sizes.items() if size < highest / FLAT}:
        highest = max(sizes.values())
        panels.append(panel._replace(fitted=list(sizes)))
    return panels


def beyond_text(panel: Panel) -> str:
    """Which curves are for the most part outside the limits of a panel."""
    low, high = panel_limits(panel)
    gone = [
        curve.label
        for curve in panel.curves
        if np.mean(~((curve.values >= low) & (curve.values <= high))) > MOSTLY
    ]
    return f"beyond: {', '.join(gone)}" if gone else ""


def curve_inside(curve: SignalCurve, window: TimeWindow) -> SignalCurve:
    """The samples that a window shows."""
    shown = (curve.time >= window.start - SAME_TIME) & (curve.time <= window.stop + SAME_TIME)
    return curve._replace(time=curve.time[shown], values=curve.values[shown])


def clipped_text(panel: Panel) -> str:
    """Which curves leave a panel of the whole run and, where there is room to say, how far they reach."""
    if not panel.window.whole:
        return ""
    low, high = panel_limits(panel)
    reach = []
    for curve in panel.curves:
        values = curve_inside(curve, panel.window).values
        beyond = np.maximum(low - values, values - high)
        if np.any(beyond > 0.0):
            furthest = quantity(float(values[np.nanargmax(beyond)]), panel.unit)
            reach.append(curve.label if len(panel.curves) > 2 else f"{curve.label} to {furthest}")
    return f"clipped: {', '.join(reach)}" if reach else ""


def largest_size(curves: Sequence[Samples], tail: float = 0.0) -> float:
    """The largest size of all samples of all curves but a tail at either end of each; 0 without any."""
    low, high = sample_range(curves, tail)
    return max(abs(low), abs(high)) if low <= high else 0.0


def range_with_margin(curves: Sequence[Samples], tail: float) -> tuple[float, float]:
    """A range that holds all samples of all curves but a tail at either end of each, with a margin."""
    low, high = sample_range(curves, tail)
    if low > high:
        return -1.0, 1.0
    margin = MARGIN * (high - low) or MARGIN * abs(high) or 1.0
    return low - margin, high + margin


def sample_range(curves: Sequence[Samples], tail: float) -> tuple[float, float]:
    """The least and the largest sample but for tails; inf and -inf where there is none."""
    finite = [values[np.isfinite(values)] for values in curves]
    finite = [values for values in finite if values.size]
    low = min((float(np.quantile(values, tail)) for values in finite), default=math.inf)
    high = max((float(np.quantile(values, 1.0 - tail)) for values in finite), default=-math.inf)
    return low, high


def axis_unit(unit: str, largest: float) -> tuple[str, float]:
    """The unit of an axis and the factor to it; powers of ten go into the unit, not onto the ticks."""
    label, factor = readable_unit(unit, largest)
    if factor * largest >= 0.01:
        return label, factor
    return SMALLER.get(label, f"10⁻³ {label}"), 1e3 * factor
