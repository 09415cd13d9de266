"""What can be asked beyond numbers and their intervals, and what it says."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.core.formatting import Scale
from hydroservo.scenario.ranges import typed_scales
from hydroservo.show import UNIT, Cell, Column, Line, Mark, Table

if TYPE_CHECKING:
    from hydroservo.core.errors import HydroservoError
    from hydroservo.identification.comparison import Comparison
    from hydroservo.identification.proposal import Proposal
    from hydroservo.identification.result import Identified
    from hydroservo.scenario.tables import TableEntry

Typed = Mapping[str, Scale]
PROMISES = (
    Column("parameter"),
    *(Column("from"), Column("to"), UNIT),
    Column("times as narrow", digits=3),
)


class Further(NamedTuple):
    """What was asked beyond numbers and their intervals.

    Attributes:
        other: another scenario, fitted to the same logs.
        comparison: with it.
        proposal: for the next log.
        typed: the units in which ranges were typed, by SI unit.
        failure: why some of it is missing; None where nothing is.
    """

    other: "Identified | None" = None
    comparison: "Comparison | None" = None
    proposal: "Proposal | None" = None
    typed: Typed = MappingProxyType({})
    failure: "HydroservoError | None" = None

    def verdict(self) -> list[Line]:
        """Whether the larger of both models earns its numbers."""
        if self.comparison is None:
            return []
        lead, why = self.comparison.verdict, str(self.comparison)
        mark = Mark.GOOD if self.comparison.earns else Mark.DOUBTFUL
        return [Line(lead, f"{why.removeprefix(lead)}.", mark)]

    def remarks(self, identified: "Identified") -> list[str]:
        """What a user should know of the other scenario alone."""
        if self.other is None:
            return []
        own = [line for line in self.other.remarks if line not in identified.remarks]
        return [f"{self.other.scenario}: {line}" for line in own]

    def tables(self, identified: "Identified") -> list[Table]:
        """What is held out, missed by both models; and what would become of each interval."""
        tables = [] if self.comparison is None else [comparison_table(identified, self.comparison)]
        return tables if self.proposal is None else [*tables, proposal_table(self.proposal, self.typed)]

    def numbers(self) -> dict[str, Any]:
        """All numbers of it, in SI units."""
        numbers: dict[str, Any] = {}
        if self.comparison is not None:
            held = {" ".join(key): list(both) for key, both in self.comparison.held_out.items()}
            numbers["comparison"] = self.comparison._asdict() | {"held_out": held}
        if self.proposal is not None:
            one = self.proposal
            promises = {path: each._asdict() for path, each in one.promises.items()}
            kept = {"promises": promises, "reached": one.reached, "bounds": one.bounds}
            numbers["proposal"] = {"name": one.name, "asked": list(one.asked), **kept}
        return numbers


NOTHING_FURTHER = Further()


def typed_units(identified: "Identified", ranges: "Mapping[str, TableEntry]") -> dict[str, Scale]:
    """The units in which ranges were typed, by SI unit: those given, and those of the scenario."""
    every = {**identified.fitted.assembly.log_ranges, **ranges}
    return typed_scales((every[path], one.unit) for path, one in identified.parameters.items())


def cells(values: Iterable[float], unit: str, typed: Typed) -> list[Cell]:
    """Numbers with their SI unit; those without one in the unit that was typed, such as %."""
    scale = None if unit else typed.get(unit)
    return [Cell(scale.of(one), scale.label) if scale else Cell(one, unit) for one in values]


def comparison_table(identified: "Identified", comparison: "Comparison") -> Table:
    """What is held out of each signal, missed by both models."""
    units = {
        (fit.understood.log.name, name): one.unit
        for fit in identified.logs
        for name, one in fit.signals.items()
    }
    single = len(identified.logs) == 1
    rows = [
        [Cell(name if single else f"{name}, {log}"), *(Cell(one, units[log, name]) for one in both), Cell()]
        for (log, name), both in comparison.held_out.items()
    ]
    errors = (Column(name, digits=3) for name in (comparison.larger, comparison.smaller))
    title = "What is held out of each signal, missed by both scenarios (rms)."
    return Table("comparison", (Column("signal"), *errors, UNIT), rows, title)


def proposal_table(proposal: "Proposal", typed: Typed) -> Table:
    """What would become of each interval."""
    rows = [
        [Cell(path), *cells((one.low, one.high), one.unit, typed), Cell(), Cell(one.times)]
        for path, one in proposal.promises.items()
    ]
    title = f"What a log of the proposed command would tell: {proposal.name}."
    note = "From and to: 95 % interval that it would leave, about what was found."
    return Table("proposal", PROMISES, rows, title, note, typed=typed)
