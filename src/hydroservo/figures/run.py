"""The plot of one run: velocity, error, command and, with an observer, its estimates."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydroservo.figures.panels import Panel, draw_panel
from hydroservo.figures.style import COLOURS, PALETTE, style
from hydroservo.figures.trace import Samples, Trace, controller_name, trace_of
from hydroservo.figures.tracking import TracedRun, add_legend, tracking_figure, truth

__all__ = ["plot_run"]

CHATTER = 10.0  # a truth that varies this many times more than its estimate is drawn beneath it


def plot_run(dataset: xr.Dataset) -> Figure:
    """Velocity and demand, error and command over time; with an observer, both disturbances and estimates.

    The error is velocity less demand. Where peaks press the error or the command flat, an enlarged panel
    follows. A run that diverged is shown up to where it was lost, as ``diverged_at`` has
    it.

    Args:
        dataset: what ``simulate`` returned, with at least the velocity, demand and command recorded.

    Raises:
        HydroservoError: one of these was not recorded.
    """
    trace = trace_of(dataset)
    name = controller_name(dataset)
    run = TracedRun(trace, "velocity", COLOURS.get(name, PALETTE[3]), 1.4)
    count = len(trace.estimates)
    with style():
        fig = tracking_figure([run], spare=count)
        for index, axis in enumerate(fig.axes[len(fig.axes) - count :]):
            draw_estimate(axis, run, index)
        fig.axes[0].set_title(title(name, trace), loc="left")
    return fig


def draw_estimate(axis: Axes, run: TracedRun, index: int) -> None:
    """A lumped disturbance and its estimate; index 0 is d_L1, 1 is d_L2."""
    disturbance, estimate = run.trace.disturbances[index], run.trace.estimates[index]
    subscript = f"{{L{index + 1}}}"
    curves = [
        run._replace(label=rf"estimate $\hat{{d}}_{subscript}$").curve(estimate),
        truth(f"disturbance $d_{subscript}$", run.trace.time, disturbance),
    ]
    draw_panel(axis, Panel(f"$d_{subscript}$", ("m/s^2", "N/s")[index], curves))
    if variation(disturbance) > CHATTER * variation(estimate):  # a chattering command makes d_L2 a black band
        axis.lines[0].set_zorder(axis.lines[1].get_zorder() + 0.1)
    add_legend(axis)


def variation(signal: Samples) -> float:
    return float(np.nansum(np.abs(np.diff(signal))))


def title(name: str, trace: Trace) -> str:
    return f"{name}, diverged at {trace.time[-1]:.3g} s" if trace.diverged else name
