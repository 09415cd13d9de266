"""The plot of one run: what is controlled, error and command, pressures and an observer's estimates."""

import xarray as xr
from matplotlib.axes import Axes

from hydroservo.figures.panels import Curve, Panel, draw_panel
from hydroservo.figures.style import COLOURS, GREY, PALETTE, Plot, style
from hydroservo.figures.trace import Trace, trace_of
from hydroservo.figures.tracking import TracedRun, add_legend, calm_on_top, tracking_figure, truth, whole
from hydroservo.runs.behaviour import oscillation_note
from hydroservo.runs.results import metrics_of
from hydroservo.runs.titles import controller_name, controller_title

PRESSURES = {"chamber A": PALETTE[4], "chamber B": PALETTE[5], "supply": GREY}


def plot_run(dataset: xr.Dataset) -> Plot:
    """What is controlled, error and command over time; with an observer, both disturbances and estimates.

    Where both chambers' pressures were recorded, they are shown with the supply's.

    The error is the demand less the controlled signal. Where peaks press the error or the command flat, an
    enlarged panel follows. A run that diverged is shown up to where it was lost, as ``diverged_at`` has it.

    Args:
        dataset: what ``simulate`` returned, with at least the controlled signal, demand and command recorded.

    Raises:
        HydroservoError: one of these was not recorded.
    """
    trace = trace_of(dataset)
    name = controller_name(dataset)
    run = TracedRun(trace, trace.name, COLOURS.get(name, PALETTE[3]), 1.4)
    count = len(trace.estimates)
    with style():
        fig = tracking_figure([run], spare=count + bool(trace.pressures))
        spare = fig.axes[len(fig.axes) - count - bool(trace.pressures) :]
        if trace.pressures:
            draw_pressures(spare[0], run)
        for index, axis in enumerate(spare[len(spare) - count :]):
            draw_estimate(axis, run, index)
        note = oscillation_note(metrics_of(dataset))
        fig.axes[0].set_title(title(controller_title(dataset), trace, note), loc="left")
    return fig


def draw_pressures(axis: Axes, run: TracedRun) -> None:
    """The pressures in both chambers and of the supply."""
    curves = [
        Curve(name, run.trace.time, values, PRESSURES[name], 1.1)
        for name, values in run.trace.pressures.items()
    ]
    draw_panel(axis, Panel("pressure", "Pa", curves, whole([run]), zero=True))
    add_legend(axis)


def draw_estimate(axis: Axes, run: TracedRun, index: int) -> None:
    """A lumped disturbance and its estimate; index 0 is d_L1, 1 is d_L2."""
    disturbance, estimate = run.trace.disturbances[index], run.trace.estimates[index]
    subscript = f"{{L{index + 1}}}"
    curves = [
        run._replace(label=rf"estimate $\hat{{d}}_{subscript}$").curve(estimate),
        truth(f"disturbance $d_{subscript}$", run.trace.time, disturbance),
    ]
    panel = Panel(f"$d_{subscript}$", ("m/s^2", "N/s")[index], curves, whole([run]))
    draw_panel(axis, panel)
    calm_on_top(axis, panel)
    add_legend(axis)


def title(name: str, trace: Trace, note: str) -> str:
    note = f"diverged at {trace.time[-1]:.3g} s" if trace.diverged else note
    return f"{name}, {note}" if note else name
