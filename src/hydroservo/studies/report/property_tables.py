"""The rows of the report's tables of margins and of prices on the target."""

import math

from hydroservo.formatting import NONE, number
from hydroservo.studies.law_margins import LawMargins
from hydroservo.studies.on_target import OnTarget
from hydroservo.studies.report.findings import Findings

Row = dict[str, str]

KINDS = {"rough": "not linear", "unstable": "unstable"}  # of loops without margins, in words


def property_rows(found: Findings) -> dict[str, dict[str, Row]]:
    """The margins and the prices of laws, as far as they are known, by cell and law."""
    return {
        name: {law: {**margins(one.margins), **target(one.target)} for law, one in cell.properties.items()}
        for name, cell in found.at.cells.items()
    }


def kind_of(one: LawMargins) -> str:
    """What a law's loop is in small motions: linear, rough or unstable."""
    if not one.linear:
        return "rough"
    return "linear" if one.stable else "unstable"


def margins(one: LawMargins) -> Row:
    gain = number(one.gain_margin)
    if one.gain_reduction_margin > 0.0:
        gain = f"{number(one.gain_reduction_margin)} to {gain}"
    return {
        "kind": kind_of(one),
        "points": f"{one.linear} of {one.points}",
        "gain": gain,
        "phase": number(math.degrees(one.phase_margin)),
        "delay": number(1e3 * one.delay_margin),
        "disk": number(one.disk_margin),
        "peak": number(one.sensitivity_peak),
    }


def target(one: OnTarget) -> Row:
    names = ("operations", "divisions", "roots", "functions", "state", "parameters")
    return {name: count(getattr(one, name)) for name in names}


def count(value: int | None) -> str:
    return NONE if value is None else f"{value:,}"


def operations(found: Findings, law: str) -> str:
    """The most operations a sample that a law takes in any cell."""
    return most([one.operations for one in targets(found, law)])


def taken(found: Findings, law: str) -> str:
    """The most bytes of state and parameters that a law takes in any cell."""
    both = [(one.state, one.parameters) for one in targets(found, law)]
    return most([None if state is None or own is None else state + own for state, own in both])


def targets(found: Findings, law: str) -> list[OnTarget]:
    cells = found.at.cells.values()
    return [cell.properties[law].target for cell in cells if law in cell.properties]


def most(values: list[int | None]) -> str:
    known = [value for value in values if value is not None]
    return count(max(known)) if known and len(known) == len(values) else NONE
