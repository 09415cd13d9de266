"""The picture of limits over sample periods: what the law leaves, and what the best commands do."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, NullLocator

from hydroservo.core.formatting import number
from hydroservo.figures.panels import axis_unit
from hydroservo.figures.style import PALETTE, Plot, figure, style

if TYPE_CHECKING:
    from hydroservo.limits.over_periods import LimitsOverPeriods

HEIGHT = 2.8  # inch
MARGIN = 1.15  # factor of the axis beyond the shortest and the longest period
LOOKS = {  # marker, size and colour of each line, the larger ones below
    "law": ("s", 4.5, PALETTE[1]),
    "causal": ("o", 6.0, PALETTE[0]),
    "clairvoyant": ("D", 3.0, PALETTE[2]),
}


def plot_over_periods(found: "LimitsOverPeriods") -> Plot:
    """The error of the law and both limits over the sample period, on logarithmic axes.

    What is missing is left out, and so is a limit of 0.
    """
    periods = np.array([one.period for one in found.at])
    errors = {name: np.array([getattr(one, name) for one in found.at]) for name in LOOKS}
    largest = max(float(np.nanmax(one, initial=0.0)) for one in errors.values())
    unit, factor = axis_unit(found.error.unit, largest)
    time, seconds = axis_unit("s", float(periods.max()))
    with style():
        fig = figure(HEIGHT)
        axis = fig.subplots()
        for name, (marker, size, colour) in LOOKS.items():
            shown = np.where(errors[name] > 0.0, factor * errors[name], np.nan)
            axis.loglog(seconds * periods, shown, marker=marker, markersize=size, color=colour, label=name)
        axis.set_xlim(seconds * periods.min() / MARGIN, seconds * periods.max() * MARGIN)
        axis.xaxis.set_major_locator(FixedLocator((seconds * periods).tolist()))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter(lambda value, _: number(value).removesuffix(".00").removesuffix(".0"))
        axis.set_xlabel(f"sample period [{time}]")
        axis.set_ylabel(f"{found.error.meaning} [{unit}]")
        axis.legend(loc="best")
    return fig
