"""What the report of frequency responses says."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo.cli.bode import lines_of, margins_table, points_of
from hydroservo.cli.reporting import sentences, table_of
from hydroservo.figures.bode import plot_bode
from hydroservo.formatting import NONE, quantity
from hydroservo.linear.reading import READ, read_as
from hydroservo.reports.report import Picture, Report, logs_of, origin_of
from hydroservo.runs.cautions import warnings_of

if TYPE_CHECKING:
    import xarray as xr


def bode_report(command: str, scenario: str, data: "xr.Dataset", logs: Sequence[Path]) -> Report:
    """The report of frequency responses.

    Args:
        command: makes it again.
        scenario: as the user named it.
        data: what ``bode`` returned, of one point or several.
        logs: what was recorded, if anything.
    """
    caption = (
        "Magnitude, phase and coherence. Lines: the linear model. Dots, where there are any: measured, pale "
        "where the coherence is below 0.95."
    )
    return Report(
        f"{scenario} in frequency",
        [*in_short(data), *sentences(lines_of(data))],
        warnings_of(data),
        [Picture("bode", caption, plot_bode(data))],
        [table_of("margins", margins_table(scenario, data), "Margins and bandwidths.")],
        command,
        [origin_of(scenario, data.attrs)],
        logs_of(logs),
    )


def in_short(data: "xr.Dataset") -> list[str]:
    """The margins of one point as far as it has any, or what varied over several; in a sentence."""
    points = points_of(data)
    if len(points) > 1:
        name, unit = data["point"].attrs["long_name"], data["point"].attrs["units"]
        low, high = (quantity(float(data["point"][end]), unit) for end in (0, -1))
        return [f"{name} at {len(points)} values from {low} to {high}."]
    one, names = points[0], ("gain_margin", "phase_margin", "oscillation_gain", "bandwidth")
    shown = [name for name in names if not math.isnan(float(one[name]))]
    if not shown:
        return []
    said = ", ".join(f"{READ[name][0]} {read_as(float(one[name]), READ[name][1], NONE)}" for name in shown)
    return [f"{said[0].upper()}{said[1:]}."]
