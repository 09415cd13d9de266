"""The plot of one run, and of several on common axes."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from hydroservo.core.formatting import quantity, readable_unit
from hydroservo.figures.panels import (
    WHOLE,
    Panel,
    PlottedRun,
    Samples,
    SignalCurve,
    TimeWindow,
    beyond_text,
    draw_panel,
    enlarged_panels,
    panel_limits,
    trace_of,
)
from hydroservo.figures.style import COLOURS, GREY, PALETTE, Plot, figure, style
from hydroservo.runs.arguments import check_one_signal
from hydroservo.runs.comparison import differences
from hydroservo.runs.results import metrics_of
from hydroservo.runs.run_finding import controller_name, controller_title, oscillation_note

HEIGHT = 1.35  # inch, of a panel
LEGEND = 100  # characters that fit in a line of a legend
REMARK = 7  # points
CHATTER = 2.0  # what varies this many times more than another curve is drawn beneath it
ASIDE: Mapping[str, str] = {"color": GREY}
ALARM: Mapping[str, str] = {"color": "#000000", "fontweight": "bold"}
PRESSURES = {"chamber A": PALETTE[4], "chamber B": PALETTE[5], "supply": GREY}
WIDEST, THINNEST = 2.2, 1.0  # points
LINE = 100  # characters of a remark that fit in a line


class TracedRun(NamedTuple):
    """A run and how it is drawn."""

    trace: PlottedRun
    label: str
    colour: str
    width: float  # points

    def curve(self, values: Samples) -> SignalCurve:
        """One of the run's signals, or one made of them, as it is drawn."""
        return SignalCurve(self.label, self.trace.time, values, self.colour, self.width)


def tracking_figure(runs: Sequence[TracedRun], spare: int = 0) -> Plot:
    """What is controlled, error and command of some runs, one below the other, above some empty panels.

    Where short peaks, or one run, press another flat, an enlarged panel follows. Call it inside
    :func:`~hydroservo.figures.style.style`.
    """
    window = whole_window(runs)
    error = Panel(
        "error", runs[0].trace.unit, [run.curve(run.trace.error) for run in runs], window, zero=True
    )
    command = Panel("command", "V", [run.curve(run.trace.command) for run in runs], window, zero=True)
    panels = [
        signal_panel(runs)._replace(window=window),
        error,
        *enlarged_panels(error),
        command,
        *enlarged_panels(command),
    ]
    count = len(panels) + spare
    fig = figure(height=0.45 + HEIGHT * count)
    axes = fig.subplots(count, 1, sharex=True)
    for axis, panel in zip(axes, panels, strict=False):
        draw_panel(axis, panel)
        calm_on_top(axis, panel)
        if panel.fitted:
            axis.set_ylabel(f"{axis.get_ylabel()}\n(enlarged)")
        note = beyond_text(panel) if panel.fitted else not_shown_text(runs) if panel is command else ""
        hides = panel is command and any(run.trace.unrecorded.change for run in runs)
        axis.set_title(note, loc="right", fontsize=REMARK, **(ALARM if hides else ASIDE))
    add_legend(axes[0])
    axes[-1].set_xlabel(panels[0].window.label)
    fig.align_ylabels(axes)
    return fig


def calm_on_top(axis: Axes, panel: Panel) -> None:
    """Draw what chatters, and so becomes a band, beneath what does not."""
    limits = panel_limits(panel)
    sizes = [np.nansum(np.abs(np.diff(np.clip(curve.values, *limits)))) for curve in panel.curves]
    order: list[int] = []  # from the bottom
    for i, size in enumerate(sizes):
        hidden = (place for place, below in enumerate(order) if size > CHATTER * sizes[below])
        order.insert(next(hidden, len(order)), i)
    for place, i in enumerate(order):
        axis.lines[i].set_zorder(axis.lines[i].get_zorder() + 0.01 * place)


def whole_window(runs: Sequence[TracedRun]) -> TimeWindow:
    """The time of all runs, in ms where they are short."""
    label, factor = readable_unit("s", max(float(run.trace.time[-1]) for run in runs))
    return WHOLE._replace(label=f"time [{label}]", factor=factor)


def not_shown_text(runs: Sequence[TracedRun]) -> str:
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


def signal_panel(runs: Sequence[TracedRun]) -> Panel:
    """The controlled signal of each run, and each demand that differs from those before it."""
    drawn: list[PlottedRun] = []
    for run in runs:
        if not any(same_demand(run.trace, other) for other in drawn):
            drawn.append(run.trace)
    demands = [truth_curve("" if i else "demand", trace.time, trace.demand) for i, trace in enumerate(drawn)]
    first = runs[0].trace
    return Panel(first.name, first.unit, [*(run.curve(run.trace.signal) for run in runs), *demands])


def same_demand(one: PlottedRun, other: PlottedRun) -> bool:
    """True where two runs follow one demand as long as both are shown."""
    size = min(one.time.size, other.time.size)
    times_agree = np.array_equal(one.time[:size], other.time[:size])
    return times_agree and np.array_equal(one.demand[:size], other.demand[:size])


def truth_curve(label: str, time: Samples, values: Samples) -> SignalCurve:
    """What a curve should follow: thin, dashed and on top, so that both are seen where they agree."""
    return SignalCurve(label, time, values, COLOURS["demand"], 0.8, "--")


def add_legend(axis: Axes) -> None:
    """A legend above the axis, where it can hide no curve."""
    _, labels = axis.get_legend_handles_labels()
    widths = [len(label) + 6 for label in labels]
    columns = len(labels) if sum(widths) <= LEGEND else max(LEGEND // max(widths), 1)
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderpad=0.1)


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
        fig.axes[0].set_title(run_title(controller_title(dataset), trace, note), loc="left")
    return fig


def draw_pressures(axis: Axes, run: TracedRun) -> None:
    """The pressures in both chambers and of the supply."""
    curves = [
        SignalCurve(name, run.trace.time, values, PRESSURES[name], 1.1)
        for name, values in run.trace.pressures.items()
    ]
    draw_panel(axis, Panel("pressure", "Pa", curves, whole_window([run]), zero=True))
    add_legend(axis)


def draw_estimate(axis: Axes, run: TracedRun, index: int) -> None:
    """A lumped disturbance and its estimate; index 0 is d_L1, 1 is d_L2."""
    disturbance, estimate = run.trace.disturbances[index], run.trace.estimates[index]
    subscript = f"{{L{index + 1}}}"
    curves = [
        run._replace(label=rf"estimate $\hat{{d}}_{subscript}$").curve(estimate),
        truth_curve(f"disturbance $d_{subscript}$", run.trace.time, disturbance),
    ]
    panel = Panel(f"$d_{subscript}$", ("m/s^2", "N/s")[index], curves, whole_window([run]))
    draw_panel(axis, panel)
    calm_on_top(axis, panel)
    add_legend(axis)


def run_title(name: str, trace: PlottedRun, note: str) -> str:
    note = f"diverged at {trace.time[-1]:.3g} s" if trace.diverged else note
    return f"{name}, {note}" if note else name


def plot_comparison(datasets: Sequence[xr.Dataset], labels: Sequence[str]) -> Plot:
    """Velocity, error and command of several runs, overlaid.

    The error is the demand less the controlled signal. The first run of a PI, Backstepping or TSMC
    controller has the colour that this controller has in all figures. A run that diverged is shown up to
    where its error is lost, as a number of it was. Where the runs differ in more than their controllers, a
    line below says in what.

    Args:
        datasets: what ``simulate`` returned for each run.
        labels: what the legend calls each run.

    Raises:
        ParameterError: they control different signals.
        HydroservoError: the controlled signal, demand or command of a run was not recorded.
    """
    traces = [trace_of(dataset) for dataset in datasets]
    check_one_signal("results", [trace.name for trace in traces])
    notes = [
        "diverged" if trace.diverged else oscillation_note(metrics_of(dataset))
        for trace, dataset in zip(traces, datasets, strict=True)
    ]
    names = [
        literal_label(label) + (f" ({note})" if note else "")
        for label, note in zip(labels, notes, strict=True)
    ]
    colours = distinct_colours([controller_name(dataset) for dataset in datasets])
    # Later curves are thinner, so that those beneath are seen where runs agree.
    widths = np.linspace(WIDEST, THINNEST, len(traces))
    with style():
        fig = tracking_figure([TracedRun(*row) for row in zip(traces, names, colours, widths, strict=True)])
        if unequal := differences(datasets):
            fig.supxlabel(unequal_remark(unequal), fontsize=REMARK, color=GREY)
    return fig


def unequal_remark(unequal: Iterable[str]) -> str:
    """In what runs differ, in one line: paths, or where these are too many the tables that hold them."""
    paths = list(unequal)
    tables = dict.fromkeys(path.partition(".")[0] for path in paths)
    line = f"unequal conditions: {', '.join(paths)}"
    return line if len(line) <= LINE else f"unequal conditions in {', '.join(tables)}"


def literal_label(label: str) -> str:
    """A label that matplotlib neither reads as a formula nor leaves out for its leading underscore."""
    shown = label.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def distinct_colours(names: Sequence[str]) -> list[str]:
    """A colour for each run: its controller's own if that is still free, else the next free one in turn."""
    first = {name: names.index(name) for name in names if name in COLOURS}
    free = cycle([colour for colour in PALETTE if colour not in {COLOURS[name] for name in first}])
    return [COLOURS[name] if first.get(name) == i else next(free) for i, name in enumerate(names)]
