"""Velocity, error and command of one or several runs, one below the other."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydroservo.figures.panels import Curve, Panel, beyond, draw_panel, enlarged
from hydroservo.figures.style import COLOURS, figure
from hydroservo.figures.trace import Samples, Trace

__all__ = ["TracedRun", "add_legend", "tracking_figure", "truth"]

HEIGHT = 1.35  # inch, of a panel
LEGEND = 100  # characters that fit in a line of a legend


class TracedRun(NamedTuple):
    """A run and how it is drawn."""

    trace: Trace
    label: str
    colour: str
    width: float  # points

    def curve(self, values: Samples) -> Curve:
        """One of the run's signals, or one made of them, as it is drawn."""
        return Curve(self.label, self.trace.time, values, self.colour, self.width)


def tracking_figure(runs: Sequence[TracedRun], spare: int = 0) -> Figure:
    """Velocity, error and command of some runs, one below the other, above a number of empty panels.

    Where short peaks, or one run, press another flat, an enlarged panel follows. Call it inside
    :func:`~hydroservo.figures.style.style`.
    """
    error = Panel("error", "m/s", [run.curve(run.trace.error) for run in runs], zero=True)
    command = Panel("command", "V", [run.curve(run.trace.command) for run in runs], zero=True)
    panels = [velocities(runs), error, *enlarged(error), command, *enlarged(command)]
    count = len(panels) + spare
    fig = figure(height=0.45 + HEIGHT * count)
    axes = fig.subplots(count, 1, sharex=True)
    for axis, panel in zip(axes, panels, strict=False):
        draw_panel(axis, panel)
        if panel.fitted:
            axis.set_ylabel(f"{axis.get_ylabel()}\n(enlarged)")
            axis.set_title(beyond(panel), loc="right", fontsize=7, color="#555555")
    add_legend(axes[0])
    axes[-1].set_xlabel("time [s]")
    fig.align_ylabels(axes)
    return fig


def velocities(runs: Sequence[TracedRun]) -> Panel:
    """The velocity of each run, and each demand that differs from those before it."""
    drawn: list[Trace] = []
    for run in runs:
        if not any(same_demand(run.trace, other) for other in drawn):
            drawn.append(run.trace)
    demands = [truth("" if i else "demand", trace.time, trace.demand) for i, trace in enumerate(drawn)]
    return Panel("velocity", "m/s", [*(run.curve(run.trace.velocity) for run in runs), *demands])


def same_demand(one: Trace, other: Trace) -> bool:
    """True where two runs follow one demand as long as both are shown."""
    size = min(one.time.size, other.time.size)
    times_agree = np.array_equal(one.time[:size], other.time[:size])
    return times_agree and np.array_equal(one.demand[:size], other.demand[:size])


def truth(label: str, time: Samples, values: Samples) -> Curve:
    """What a curve should follow: thin, dashed and on top, so that both are seen where they agree."""
    return Curve(label, time, values, COLOURS["demand"], 0.8, "--")


def add_legend(axis: Axes) -> None:
    """A legend above the axis, where it can hide no curve."""
    _, labels = axis.get_legend_handles_labels()
    widths = [len(label) + 6 for label in labels]
    columns = len(labels) if sum(widths) <= LEGEND else max(LEGEND // max(widths), 1)
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderpad=0.1)
