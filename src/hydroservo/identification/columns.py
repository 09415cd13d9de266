"""Which column of a log holds which signal, in which unit."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hydroservo.errors import ScenarioError, short
from hydroservo.field import Field
from hydroservo.identification.signals import COMMAND, OUTPUTS, SIGNALS, TIME, WRITTEN
from hydroservo.nearest import one_of
from hydroservo.scenario.quantities import unit_factor
from hydroservo.scenario.recordings import name_and_unit

__all__ = ["Column", "chosen_columns"]


class Column(NamedTuple):
    """A column of a log.

    Attributes:
        signal: what it holds.
        header: as the log calls it.
        place: its number, from 0 on.
        factor: SI units per unit of its numbers.
    """

    signal: str
    header: str
    place: int
    factor: float


def chosen_columns(
    headers: Sequence[str],
    mapping: Mapping[str, str],
    name: str,
    needed: Sequence[str] = (TIME, COMMAND),
    signals: Mapping[str, Field] = SIGNALS,
    place: str = "line 1",
) -> list[Column]:
    """The columns of a log that hold signals, time first.

    Args:
        headers: of all its columns, such as ``velocity [mm/s]``.
        mapping: the column of a signal, with the unit that it is in where its header gives another or none,
            such as ``{"velocity": "v_piston [mm/s]"}``; a signal without one has a column of its own name,
            or of that which a run of ours writes.
        name: of the log.
        needed: signals without which the log is none.
        signals: that are sought, with their units.
        place: in the log, where the headers stand.

    Raises:
        ScenarioError: a column is missing, appears twice or has the unit of something else; or there is
            not what is needed, or nothing measured.
    """
    cells = [(header.strip(), *name_and_unit(header.strip())) for header in headers]
    found = [
        column_of(signal, field, cells, mapping.get(signal), (name, place))
        for signal, field in signals.items()
    ]
    columns = [one for one in found if one is not None]
    known = {one.signal for one in columns}
    for signal in needed:
        if signal not in known:
            raise missing(signal, cells, (name, place))
    if not known & set(OUTPUTS):
        problem = f"has no column of anything measured; one must be {', '.join(OUTPUTS)}"
        raise ScenarioError(name, place, f"{problem}, or [identify.columns] say which is")
    return columns


def column_of(
    signal: str,
    field: Field,
    cells: Sequence[tuple[str, str, str]],
    wanted: str | None,
    where: tuple[str, str],
) -> Column | None:
    """The column of one signal; None if no column has its name and none is wanted."""
    own, unit = name_and_unit(wanted) if wanted is not None else (usual(signal, cells), "")
    places = [i for i, cell in enumerate(cells) if {own, wanted} & set(cell[:2])]
    if len(places) > 1:
        raise ScenarioError(*where, f"column {short(own)} appears more than once")
    if not places:
        if wanted is None:
            return None
        problem = (
            f"column {short(own)} for {signal} is missing; it {one_of(own, [cell[1] for cell in cells])}"
        )
        raise ScenarioError(*where, problem)
    header, _, given = cells[places[0]]
    unit = unit or given
    if not unit:
        example = f'"{header} [{field.unit}]", or the unit that it is in'
        problem = f"has no unit; write {example}, there or as [identify.columns] {signal}"
        raise ScenarioError(*where, f"column {short(header)} {problem}")
    try:
        factor = float(unit_factor(unit, field.unit))
    except ValueError as error:
        raise ScenarioError(*where, f"column {short(header)} {error}, as {signal} must") from None
    return Column(signal, header, places[0], factor)


def usual(signal: str, cells: Sequence[tuple[str, str, str]]) -> str:
    """The name of a signal's column where nobody says which it is."""
    there = {name for _, name, _ in cells}
    return next((name for name in (signal, *WRITTEN.get(signal, ())) if name in there), signal)


def missing(signal: str, cells: Sequence[tuple[str, str, str]], where: tuple[str, str]) -> ScenarioError:
    """That a log lacks a column that it must have."""
    unit = SIGNALS[signal].unit
    own = f'[identify.columns] {signal} = "COLUMN [{unit}]"'
    names = ", ".join(cell[1] for cell in cells)
    return ScenarioError(*where, f'column "{signal} [{unit}]" is missing among {names}; {own} names it')
