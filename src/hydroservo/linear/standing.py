"""How far loops are from oscillating, before a search of their gains and after it."""

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.control.monitors import Oscillation
from hydroservo.core.block import replace
from hydroservo.core.field import Field
from hydroservo.core.formatting import NONE
from hydroservo.linear.margins import UNTOLD
from hydroservo.linear.onset import longer
from hydroservo.linear.reading import READ, margin_in, read_as
from hydroservo.linear.view import onset_of, viewed
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.show import Cell, Column, Table


class Standing(NamedTuple):
    """How far a loop is from oscillating, as ``bode`` shows it; nan where a number cannot be had."""

    oscillation_gain: Annotated[float, Field("", "factor on the gain from which the loop oscillates")]
    gain_margin: Annotated[float, Field("", "least gain margin while moving")]
    phase_margin: Annotated[float, Field("rad", "least phase margin while moving")]
    sensitivity_peak: Annotated[float, Field("", "largest sensitivity peak while moving")]
    oscillation_command: Annotated[float, Field("V", "amplitude of the command in a sustained oscillation")]

    def __str__(self) -> str:
        shown = {name: READ[name] for name in self._fields if name in READ}
        texts = (
            f"{label} {read_as(getattr(self, name), unit, NONE)}" for name, (label, unit) in shown.items()
        )
        return ", ".join(texts)

    def cells(self) -> list[Cell]:
        """The margins of a row of a table."""
        named = {name: READ[name][1] for name in self._fields if name in READ}
        return [Cell(*margin_in(unit, getattr(self, name))) for name, unit in named.items()]


class Change(NamedTuple):
    """How a loop stands before a search and after it."""

    name: str
    before: Standing
    after: Standing

    def __str__(self) -> str:
        return f"{self.name}: before, {self.before}; after, {self.after}"

    @staticmethod
    def table(changes: "Sequence[Change]") -> Table:
        """How loops stand, a row for each before and one after."""
        margins = (Column(READ[name][0], digits=3, right=True) for name in Standing._fields if name in READ)
        rows = [
            [Cell(one.name), Cell(when), *standing.cells()]
            for one in changes
            for when, standing in (("before", one.before), ("after", one.after))
        ]
        return Table(
            "margins", (Column("machine"), Column("values"), *margins), rows, "Margins while moving."
        )


def standing_of(loop: Loop) -> Standing:
    """How far a loop is from oscillating; the oscillation is that of a run 5 s longer than its own."""
    run = quietly(simulate)(longer(loop), record=(), metrics=[Oscillation()])
    amplitude = math.inf if run["diverged"] else float(run["oscillation_command"])
    try:
        view = viewed(loop, None, None, None)
    except UNTOLD:
        return Standing(onset_of(loop, None), math.nan, math.nan, math.nan, amplitude)
    margins = view.trusted.margins
    return Standing(
        view.onset, margins.gain_margin, margins.phase_margin, margins.sensitivity_peak, amplitude
    )


def changes_of(loops: Mapping[str, Loop], parameters: Mapping[str, float]) -> list[Change]:
    """How loops stand with their own values, and with others."""
    return [
        Change(name, standing_of(loop), standing_of(replace(loop, parameters)))
        for name, loop in loops.items()
    ]
