"""How margins and bandwidths are called, and in which unit they are read."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.core.formatting import quantity
from hydroservo.linear.onset import MOST
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Table

if TYPE_CHECKING:
    from hydroservo.linear.margins import Margins

READ = {
    "gain_margin": ("gain margin", "dB"),
    "phase_margin": ("phase margin", "rad"),
    "delay_margin": ("delay margin", "s"),
    "disk_margin": ("disk margin", ""),
    "sensitivity_peak": ("sensitivity peak", "dB"),
    "oscillation_gain": ("oscillates from", "onset"),
    "bandwidth": ("bandwidth, \N{MINUS SIGN}3 dB", "Hz"),
    "bandwidth_90": ("bandwidth, \N{MINUS SIGN}90\N{DEGREE SIGN}", "Hz"),
}

OSCILLATES, UNSTABLE = Cell("oscillates", mark=Mark.QUIET), Cell("unstable", mark=Mark.QUIET)


def read_as(value: float, unit: str, missing: str) -> str:
    """A number in the unit in which it is read.

    Args:
        value: as :func:`margin_in` has it.
        unit: likewise.
        missing: what stands for nan.
    """
    shown, unit = margin_in(unit, value)
    if isinstance(shown, str):
        return shown
    return missing if math.isnan(shown) else quantity(shown, unit)


def margin_in(unit: str, value: float) -> tuple[float | str, str]:
    """A number and its SI unit, in dB for a ratio; a text for an onset of oscillation that is not a number.

    Args:
        unit: of those in ``READ``.
        value: in SI units; a ratio where the unit is dB, a factor on the gain where it is "onset".
    """
    if unit == "onset" and value in (1.0, math.inf):
        return "as it stands" if value == 1.0 else f"none up to {MOST:g} dB", ""
    if unit in ("dB", "onset"):
        return -math.inf if value == 0.0 else 20.0 * math.log10(value), "dB"
    return value, unit


def margins_finding(margins: "Margins") -> Finding:
    """What the margins of a loop say.

    Args:
        margins: what ``margins`` returned.
    """
    numbers = margins._asdict()
    return Finding(
        "Margins", verdict([numbers]), [], [margins_table(["quantity", "value"], [numbers])], [], numbers
    )


def verdict(points: Sequence[Mapping[str, Any]]) -> list[Line]:
    """That a loop oscillates or is unstable, at its point or at some of many."""
    some = f" at {{}} of {len(points)} values, so it has no margins there." if len(points) > 1 else ""
    for lead, rest, lost in (
        ("The loop oscillates", " as it stands", [one.get("oscillation_gain") == 1.0 for one in points]),
        ("The loop is unstable", " for small motions", [not one["stable"] for one in points]),
    ):
        if any(lost):
            where = some.format(sum(lost)) or ", so it has no margins."
            return [Line(lead, rest + where, Mark.BAD)]
    return []


def margins_table(headings: Sequence[str], points: Sequence[Mapping[str, Any]]) -> Table:
    """Margins and bandwidths, a column for each point.

    Args:
        headings: of the names of the rows, then of each point.
        points: the numbers of each.
    """
    rows = [
        [Cell(label), *(margin_cell(name, one) for one in points), Cell()]
        for name, (label, _) in READ.items()
        if name in points[0]
    ]
    values = [Column(heading, digits=3, right=True) for heading in headings[1:]]
    return Table("margins", (Column(headings[0]), *values, UNIT), rows, "Margins and bandwidths.")


def margin_cell(name: str, point: Mapping[str, Any]) -> Cell:
    """A margin, or why there is none."""
    value, unit = margin_in(READ[name][1], point[name])
    if isinstance(value, float) and math.isnan(value):
        if point.get("oscillation_gain") == 1.0:
            return OSCILLATES
        if not point["stable"]:
            return UNSTABLE
    return Cell(value, unit)
