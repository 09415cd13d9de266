"""The plot of one run: velocity, error, command and, with an observer, its estimates."""

import tomllib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydroservo.errors import HydroservoError
from hydroservo.figures.style import COLOURS, PALETTE, figure, style
from hydroservo.results import readable_unit

__all__ = ["Curve", "Trace", "controller_name", "plot_run", "trace_of", "tracking_figure"]

PANEL = 1.35  # inch
LEGEND = 100  # characters that fit in a line of a legend
LARGEST_VECTOR = 20_000  # points; a longer curve becomes pixels inside an SVG, which would else be huge
LOST = 10.0  # peak demands; a diverged run is shown up to this error
USUAL = 0.8  # quantile of a curve's size that stands for all but its peaks
FLAT = 15.0  # a curve this many times below the highest peak is pressed flat
FLATTEST = 1e5  # and this many times below it, is nothing but rounding
CHATTER = 10.0  # a truth that varies this many times more than its estimate is drawn beneath it
NAMES = {"PI": "PI", "Backstepping": "backstepping", "TSMC": "TSMC"}


class Trace(NamedTuple):
    """What a plot shows of a run, in SI units; a diverged run ends where it diverged."""

    time: np.ndarray
    demand: np.ndarray
    velocity: np.ndarray
    error: np.ndarray  # velocity less demand
    command: np.ndarray
    disturbances: tuple[np.ndarray, ...]  # d_L1 [m/s^2] and d_L2 [N/s]
    estimates: tuple[np.ndarray, ...]  # of both; empty without an observer
    diverged: bool


class Curve(NamedTuple):
    """How a run is drawn."""

    trace: Trace
    label: str
    colour: str
    width: float  # points


class Panel(NamedTuple):
    """One quantity of all runs on one axis."""

    quantity: str
    unit: str
    signals: Sequence[np.ndarray]  # one for each run
    limit: float | None = None  # of an enlarged axis on both sides of zero


def plot_run(dataset: xr.Dataset) -> Figure:
    """Velocity and demand, error and command over time; with an observer, both disturbances and estimates.

    The error is velocity less demand. Where peaks press the error or the command flat, an enlarged panel
    follows. A run that diverged is shown up to where its error passes ten peak demands.

    Args:
        dataset: what ``simulate`` returned, with at least the velocity, demand and command recorded.

    Raises:
        HydroservoError: one of these was not recorded.
    """
    trace = trace_of(dataset)
    name = controller_name(dataset)
    curve = Curve(trace, "velocity", COLOURS.get(name, PALETTE[3]), 1.4)
    with style():
        fig = tracking_figure([curve], spare=len(trace.estimates))
        for number in range(len(trace.estimates)):
            draw_estimate(fig.axes[number - len(trace.estimates)], curve, number)
        fig.axes[0].set_title(title(name, trace), loc="left")
    return fig


def tracking_figure(curves: Sequence[Curve], spare: int = 0) -> Figure:
    """Velocity, error and command of some runs, one below the other, above a number of empty panels.

    Call it inside :func:`style`.
    """
    panels = tracking_panels([curve.trace for curve in curves])
    count = 1 + len(panels) + spare
    fig = figure(height=0.45 + PANEL * count)
    axes = fig.subplots(count, 1, sharex=True)
    draw_velocities(axes[0], curves)
    for axis, panel in zip(axes[1:], panels, strict=False):
        draw_panel(axis, panel, curves)
    axes[-1].set_xlabel("time [s]")
    fig.align_ylabels(axes)
    return fig


def tracking_panels(traces: Sequence[Trace]) -> list[Panel]:
    """The error and the command, each followed by an enlarged panel where that is needed."""
    panels = []
    for whole in (
        Panel("error", "m/s", [trace.error for trace in traces]),
        Panel("command", "V", [trace.command for trace in traces]),
    ):
        panels.append(whole)
        limit = enlarged_limit(whole.signals)
        if limit is not None:
            panels.append(whole._replace(limit=limit))
    return panels


def enlarged_limit(signals: Sequence[np.ndarray]) -> float | None:
    """How far an enlarged axis reaches on both sides of zero; None if the whole axis shows enough.

    It is needed where short peaks, or one run, press another flat. It then reaches just beyond the usual size
    of each run that is not itself many times larger than the smallest.
    """
    usual = [float(np.quantile(finite_sizes(signal), USUAL)) for signal in signals]
    least, highest = min(usual), largest(signals)
    if not highest / FLATTEST < least < highest / FLAT:
        return None
    return 1.25 * max(size for size in usual if size < FLAT * least)


def largest(signals: Sequence[np.ndarray]) -> float:
    return max(float(finite_sizes(signal).max()) for signal in signals)


def finite_sizes(signal: np.ndarray) -> np.ndarray:
    """|x| of each finite number; a zero where there is none."""
    finite = signal[np.isfinite(signal)]
    return np.abs(finite) if finite.size else np.zeros(1)


def draw_velocities(axis: Axes, curves: Sequence[Curve]) -> None:
    """The velocity of each run, and each demand that differs from those before it."""
    drawn: list[Trace] = []
    for curve in curves:
        plot(axis, curve.trace.time, 1e3 * curve.trace.velocity, curve.colour, curve.width, curve.label)
    for trace in (curve.trace for curve in curves):
        if not any(same_demand(trace, other) for other in drawn):
            plot_truth(axis, trace.time, 1e3 * trace.demand, "" if drawn else "demand")
            drawn.append(trace)
    axis.set_ylabel("velocity [mm/s]")
    add_legend(axis)


def same_demand(one: Trace, other: Trace) -> bool:
    """True where two runs follow one demand as long as both are shown."""
    size = min(one.time.size, other.time.size)
    times_agree = np.array_equal(one.time[:size], other.time[:size])
    return times_agree and np.array_equal(one.demand[:size], other.demand[:size])


def draw_panel(axis: Axes, panel: Panel, curves: Sequence[Curve]) -> None:
    label, factor = readable_unit(panel.unit, panel.limit or largest(panel.signals))
    for curve, signal in zip(curves, panel.signals, strict=True):
        plot(axis, curve.trace.time, factor * signal, curve.colour, curve.width)
    if panel.limit is None:
        axis.set_ylabel(f"{panel.quantity} [{label}]")
    else:
        axis.set_ylabel(f"{panel.quantity} [{label}]\n(enlarged)")
        axis.set_ylim(-factor * panel.limit, factor * panel.limit)


def draw_estimate(axis: Axes, curve: Curve, number: int) -> None:
    """A lumped disturbance and its estimate; number 0 is d_L1, 1 is d_L2."""
    truth, estimate = curve.trace.disturbances[number], curve.trace.estimates[number]
    label, factor = readable_unit(("m/s^2", "N/s")[number], largest([truth, estimate]))
    index = f"{{L{number + 1}}}"
    time = curve.trace.time
    plot(axis, time, factor * estimate, curve.colour, curve.width, rf"estimate $\hat{{d}}_{index}$")
    plot_truth(axis, time, factor * truth, f"disturbance $d_{index}$")
    if variation(truth) > CHATTER * variation(estimate):  # a chattering command makes d_L2 a black band
        axis.lines[0].set_zorder(axis.lines[1].get_zorder() + 0.1)
    axis.set_ylabel(f"$d_{index}$ [{label}]")
    add_legend(axis)


def variation(signal: np.ndarray) -> float:
    return float(np.nansum(np.abs(np.diff(signal))))


def plot(
    axis: Axes, time: np.ndarray, values: np.ndarray, colour: str, width: float, label: str = ""
) -> None:
    pixels = time.size > LARGEST_VECTOR
    axis.plot(time, values, color=colour, linewidth=width, label=label or None, rasterized=pixels)


def plot_truth(axis: Axes, time: np.ndarray, values: np.ndarray, label: str) -> None:
    """What a curve should follow: thin, dashed and on top, so that both are seen where they agree."""
    pixels = time.size > LARGEST_VECTOR
    colour = COLOURS["demand"]
    axis.plot(time, values, "--", color=colour, linewidth=0.8, label=label or None, rasterized=pixels)


def add_legend(axis: Axes) -> None:
    """A legend above the axis, where it can hide no curve."""
    _, labels = axis.get_legend_handles_labels()
    widths = [len(label) + 6 for label in labels]
    columns = len(labels) if sum(widths) <= LEGEND else max(LEGEND // max(widths), 1)
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderpad=0.1)


def title(name: str, trace: Trace) -> str:
    return f"{name}, diverged at {trace.time[-1]:.3g} s" if trace.diverged else name


def trace_of(dataset: xr.Dataset) -> Trace:
    """The signals that plots show.

    Raises:
        HydroservoError: a signal was not recorded.
    """
    missing = [path for path in ("plant.velocity", "reference.value", "controller.u") if path not in dataset]
    if missing:
        raise HydroservoError(f"a plot needs {', '.join(missing)}, which this run did not record")
    demand, velocity = dataset["reference.value"].values, dataset["plant.velocity"].values
    diverged = bool(dataset["diverged"])
    end = length_shown(demand, velocity) if diverged else demand.size
    estimates = estimate_paths(dataset)
    truths = ("disturbance.d1", "disturbance.d2") if estimates else ()
    return Trace(
        time=dataset["time"].values[:end],
        demand=demand[:end],
        velocity=velocity[:end],
        error=(velocity - demand)[:end],
        command=dataset["controller.u"].values[:end],
        disturbances=tuple(dataset[path].values[:end] for path in truths),
        estimates=tuple(dataset[path].values[:end] for path in estimates),
        diverged=diverged,
    )


def length_shown(demand: np.ndarray, velocity: np.ndarray) -> int:
    """How many samples of a diverged run come before its error is lost; at least two."""
    error = np.abs(velocity - demand)
    lost = ~(error <= LOST * np.nanmax(np.abs(demand)))
    return max(int(np.argmax(lost)) if lost.any() else demand.size, 2)


def estimate_paths(dataset: xr.Dataset) -> tuple[str, ...]:
    """The paths of the controller's first pair of estimates d1 and d2, if recorded, and their truth too."""
    if "disturbance.d1" not in dataset or "disturbance.d2" not in dataset:
        return ()
    for name in map(str, dataset.data_vars):
        holder, _, last = name.rpartition(".")
        if name.startswith("controller.") and last == "d1" and f"{holder}.d2" in dataset:
            return (name, f"{holder}.d2")
    return ()


def controller_name(dataset: xr.Dataset) -> str:
    """The controller of a run by the name that figures give it."""
    kind = str(tomllib.loads(dataset.attrs["scenario"])["controller"]["type"])
    return NAMES.get(kind, kind)
