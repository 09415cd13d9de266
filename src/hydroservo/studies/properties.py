"""What no run says of a law in a cell: its margins, and its price on the target; units of work."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.block import replace
from hydroservo.loop import Loop
from hydroservo.runs.provenance import scenario_text
from hydroservo.studies.cells import Entrant
from hydroservo.studies.law_margins import LawMargins, law_margins
from hydroservo.studies.on_target import OnTarget, on_target
from hydroservo.work.unit import Unit, address

if TYPE_CHECKING:
    import pyarrow as pa

    from hydroservo.work.store import Store

__all__ = ["Examined", "Properties", "examined", "properties_in"]

Gains = Mapping[tuple[str, str], Mapping[str, float]]  # by cell and law


class Properties(NamedTuple):
    """What no run says of a law in a cell.

    Attributes:
        margins: in small motions.
        target: what it takes there.
    """

    margins: LawMargins
    target: OnTarget


class Examined(NamedTuple):
    """A law in a cell, and the unit that computes its properties."""

    cell: str
    law: str
    unit: Unit


def examined(entrants: Sequence[Entrant], gains: Gains) -> Iterator[Examined]:
    """Each law in each cell, with the gains that stand for it.

    Args:
        entrants: each law in each cell.
        gains: what :func:`~hydroservo.studies.middle.middle_gains` found.
    """
    for one in entrants:
        cell, law = one.cell.name, one.law.name
        loops = [replace(kind.loop, gains[cell, law]) for kind in one.contender.assemblies.values()]
        key = address({"properties": [scenario_text(loop) for loop in loops]})
        yield Examined(cell, law, Unit(key, partial(found_by, loops), f"margins of {law} in {cell}"))


def found_by(loops: Sequence[Loop]) -> "pa.Table":
    """The row of a law in a cell, from its loops for each kind of condition."""
    import pyarrow as pa

    row = {**law_margins(loops)._asdict(), **on_target(loops[0])._asdict()}
    schema = pa.schema([(name, getattr(pa, kind)()) for name, kind in COLUMNS.items()])
    return pa.table({name: [value] for name, value in row.items()}, schema=schema)


COLUMNS = {
    "points": "int64",
    "linear": "int64",
    "stable": "bool_",
    "gain_margin": "float64",
    "gain_reduction_margin": "float64",
    "phase_margin": "float64",
    "delay_margin": "float64",
    "disk_margin": "float64",
    "sensitivity_peak": "float64",
    "nonlinear": "string",
    **dict.fromkeys(OnTarget._fields[:-1], "int64"),
    "uncounted": "string",
}


def properties_in(store: "Store", found: Sequence[Examined]) -> dict[str, dict[str, Properties]]:
    """The properties of each law, by cell and law, from the units that are done."""
    properties: dict[str, dict[str, Properties]] = {}
    for one in found:
        (row,) = store.read(one.unit.key).to_pylist()
        margins = LawMargins(**{name: row[name] for name in LawMargins._fields})
        target = OnTarget(**{name: row[name] for name in OnTarget._fields})
        properties.setdefault(one.cell, {})[one.law] = Properties(margins, target)
    return properties
