"""The plot of several runs on common axes."""

from collections.abc import Iterable, Sequence
from itertools import cycle

import numpy as np
import xarray as xr

from hydroservo.figures.style import COLOURS, GREY, PALETTE, Plot, style
from hydroservo.figures.trace import trace_of
from hydroservo.figures.tracking import TracedRun, tracking_figure
from hydroservo.runs.arguments import check_one_signal
from hydroservo.runs.behaviour import oscillation_note
from hydroservo.runs.conditions import differences
from hydroservo.runs.results import metrics_of
from hydroservo.runs.titles import controller_name

WIDEST, THINNEST = 2.2, 1.0  # points
REMARK, LINE = 7, 100  # points, and the characters of that size that fit in a line


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
        literal(label) + (f" ({note})" if note else "") for label, note in zip(labels, notes, strict=True)
    ]
    colours = distinct_colours([controller_name(dataset) for dataset in datasets])
    # Later curves are thinner, so that those beneath are seen where runs agree.
    widths = np.linspace(WIDEST, THINNEST, len(traces))
    with style():
        fig = tracking_figure([TracedRun(*row) for row in zip(traces, names, colours, widths, strict=True)])
        if unequal := differences(datasets):
            fig.supxlabel(remark(unequal), fontsize=REMARK, color=GREY)
    return fig


def remark(unequal: Iterable[str]) -> str:
    """In what runs differ, in one line: paths, or where these are too many the tables that hold them."""
    paths = list(unequal)
    tables = dict.fromkeys(path.partition(".")[0] for path in paths)
    line = f"unequal conditions: {', '.join(paths)}"
    return line if len(line) <= LINE else f"unequal conditions in {', '.join(tables)}"


def literal(label: str) -> str:
    """A label that matplotlib neither reads as a formula nor leaves out for its leading underscore."""
    shown = label.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def distinct_colours(names: Sequence[str]) -> list[str]:
    """A colour for each run: its controller's own if that is still free, else the next free one in turn."""
    first = {name: names.index(name) for name in names if name in COLOURS}
    free = cycle([colour for colour in PALETTE if colour not in {COLOURS[name] for name in first}])
    return [COLOURS[name] if first.get(name) == i else next(free) for i, name in enumerate(names)]
