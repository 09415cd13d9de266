"""What is controlled, error and command of one or several runs, one below the other."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from hydroservo.figures.panels import WHOLE, Curve, Panel, Window, beyond, draw_panel, enlarged, panel_limits
from hydroservo.figures.style import COLOURS, GREY, Plot, figure
from hydroservo.figures.trace import Samples, Trace
from hydroservo.formatting import quantity, readable_unit

HEIGHT = 1.35  # inch, of a panel
LEGEND = 100  # characters that fit in a line of a legend
REMARK = 7  # points
CHATTER = 2.0  # what varies this many times more than another curve is drawn beneath it
ASIDE: Mapping[str, str] = {"color": GREY}
ALARM: Mapping[str, str] = {"color": "#000000", "fontweight": "bold"}


class TracedRun(NamedTuple):
    """A run and how it is drawn."""

    trace: Trace
    label: str
    colour: str
    width: float  # points

    def curve(self, values: Samples) -> Curve:
        """One of the run's signals, or one made of them, as it is drawn."""
        return Curve(self.label, self.trace.time, values, self.colour, self.width)


def tracking_figure(runs: Sequence[TracedRun], spare: int = 0) -> Plot:
    """What is controlled, error and command of some runs, one below the other, above some empty panels.

    Where short peaks, or one run, press another flat, an enlarged panel follows. Call it inside
    :func:`~hydroservo.figures.style.style`.
    """
    window = whole(runs)
    error = Panel(
        "error", runs[0].trace.unit, [run.curve(run.trace.error) for run in runs], window, zero=True
    )
    command = Panel("command", "V", [run.curve(run.trace.command) for run in runs], window, zero=True)
    panels = [signals(runs)._replace(window=window), error, *enlarged(error), command, *enlarged(command)]
    count = len(panels) + spare
    fig = figure(height=0.45 + HEIGHT * count)
    axes = fig.subplots(count, 1, sharex=True)
    for axis, panel in zip(axes, panels, strict=False):
        draw_panel(axis, panel)
        calm_on_top(axis, panel)
        if panel.fitted:
            axis.set_ylabel(f"{axis.get_ylabel()}\n(enlarged)")
        note = beyond(panel) if panel.fitted else not_shown(runs) if panel is command else ""
        hides = panel is command and any(run.trace.unrecorded.change for run in runs)
        axis.set_title(note, loc="right", fontsize=REMARK, **(ALARM if hides else ASIDE))
    add_legend(axes[0])
    axes[-1].set_xlabel(panels[0].window.label)
    fig.align_ylabels(axes)
    return fig


def calm_on_top(axis: Axes, panel: Panel) -> None:
    """Draw what chatters, and so becomes a band, beneath what does not."""
    limits = panel_limits(panel)
    sizes = [variation(np.clip(curve.values, *limits)) for curve in panel.curves]
    order: list[int] = []  # from the bottom
    for i, size in enumerate(sizes):
        hidden = (place for place, below in enumerate(order) if size > CHATTER * sizes[below])
        order.insert(next(hidden, len(order)), i)
    for place, i in enumerate(order):
        axis.lines[i].set_zorder(axis.lines[i].get_zorder() + 0.01 * place)


def variation(signal: Samples) -> float:
    return float(np.nansum(np.abs(np.diff(signal))))


def whole(runs: Sequence[TracedRun]) -> Window:
    """The time of all runs, in ms where they are short."""
    label, factor = readable_unit("s", max(float(run.trace.time[-1]) for run in runs))
    return WHOLE._replace(label=f"time [{label}]", factor=factor)


def not_shown(runs: Sequence[TracedRun]) -> str:
    """What the command does between recorded samples, in each run where these hide it."""
    notes = []
    for run in runs:
        change, _, peak = run.trace.unrecorded
        what = [f"changes of {quantity(change, 'V')} a sample"] if change else []
        what += [f"a peak of {quantity(peak, 'V')}"] if peak else []
        if what:
            whose = f" ({run.label})" if len(runs) > 1 else ""
            notes.append(" and ".join(what) + whose)
    line = f"between recorded samples, not shown: {', '.join(notes)}"
    return "" if not notes else line if len(line) <= LEGEND else "not all is shown between recorded samples"


def signals(runs: Sequence[TracedRun]) -> Panel:
    """The controlled signal of each run, and each demand that differs from those before it."""
    drawn: list[Trace] = []
    for run in runs:
        if not any(same_demand(run.trace, other) for other in drawn):
            drawn.append(run.trace)
    demands = [truth("" if i else "demand", trace.time, trace.demand) for i, trace in enumerate(drawn)]
    first = runs[0].trace
    return Panel(first.name, first.unit, [*(run.curve(run.trace.signal) for run in runs), *demands])


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
