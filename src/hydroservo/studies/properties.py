"""What no run says of a law in a cell: its margins, and its price on the target; units of work."""

import json
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, NamedTuple

from hydroservo.block import replace
from hydroservo.errors import HydroservoError
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.field import Field
from hydroservo.loop import Loop
from hydroservo.runs.provenance import scenario_text
from hydroservo.studies.cells import Entrant
from hydroservo.studies.choice import level_name
from hydroservo.studies.law_margins import LawMargins, law_margins
from hydroservo.work.unit import Unit, address

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from hydroservo.work.store import Store

DOUBLE = 8  # bytes
ENDLESS = "has a loop that goes on as long as its numbers ask"
UNTRANSLATED = "says what is not in the language; export says what"


class OnTarget(NamedTuple):
    """The price of a law on its target: what one sample takes at most, and how much memory.

    The numbers are those of :class:`~hydroservo.export.operations.Operations`, and None where there are none.
    """

    operations: Annotated[int | None, Field("", "operations with real numbers, all of the next five")] = None
    additions: Annotated[int | None, Field("", "additions and subtractions among them")] = None
    multiplications: Annotated[int | None, Field("", "multiplications")] = None
    divisions: Annotated[int | None, Field("", "divisions")] = None
    roots: Annotated[int | None, Field("", "square roots")] = None
    comparisons: Annotated[int | None, Field("", "comparisons")] = None
    functions: Annotated[int | None, Field("", "calls of powers, exponentials, sines and their like")] = None
    state: Annotated[int | None, Field("", "bytes of state in double precision; half in single")] = None
    parameters: Annotated[int | None, Field("", "bytes of parameters, likewise")] = None
    uncounted: Annotated[str, Field("", "why there are no numbers; or empty")] = ""


def on_target(loop: Loop) -> OnTarget:
    """What the controller of a loop takes on its target.

    It is counted in the terms of which the C is written, so that no compiler is asked, and no machine.

    Fails to know a processor: on one without double precision a division takes many times what an addition
    does. The documentation's page on the target holds the count against instructions.
    """
    try:
        unit = exported_unit(loop, Part.CONTROLLER, prefix="law", title="law")
    except HydroservoError:
        return OnTarget(uncounted=UNTRANSLATED)
    found = OnTarget(state=DOUBLE * len(unit.states), parameters=DOUBLE * len(unit.parameters))
    if unit.operations is None:
        return found._replace(uncounted=ENDLESS)
    return found._replace(operations=unit.operations.total, **unit.operations._asdict())


class Properties(NamedTuple):
    """What no run says of a law in a cell.

    Attributes:
        margins: in small motions.
        target: what it takes there.
    """

    margins: LawMargins
    target: OnTarget


class PropertyUnit(NamedTuple):
    """A law in a cell at a level, and the unit that computes its properties."""

    level: str
    cell: str
    law: str
    unit: Unit


def property_units(entrants: Sequence[Entrant], choice: "pd.DataFrame") -> Iterator[PropertyUnit]:
    """Each law in each cell at each level that it reaches, with the gains that it has there.

    Args:
        entrants: each law in each cell.
        choice: a row for each law, cell and level, with the gains as JSON in ``parameters``.
    """
    assemblies = {(one.cell.name, one.law.name): one.contender.assemblies.values() for one in entrants}
    columns = (choice[name].to_list() for name in ("level", "cell", "law", "parameters"))
    for level, cell, law, gains in zip(*columns, strict=True):
        loops = [replace(kind.loop, json.loads(gains)) for kind in assemblies[cell, law]]
        key = address({"properties": [scenario_text(loop) for loop in loops]})
        unit = Unit(key, partial(properties_table, loops), f"margins of {law} in {cell}")
        yield PropertyUnit(level_name(level), cell, law, unit)


def properties_table(loops: Sequence[Loop]) -> "pa.Table":
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


def properties_in(
    store: "Store", found: Sequence[PropertyUnit]
) -> dict[str, dict[str, dict[str, Properties]]]:
    """The properties of each law, by level, cell and law, from the units that are done."""
    properties: dict[str, dict[str, dict[str, Properties]]] = {}
    for one in found:
        (row,) = store.read(one.unit.key).to_pylist()
        margins = LawMargins(**{name: row[name] for name in LawMargins._fields})
        target = OnTarget(**{name: row[name] for name in OnTarget._fields})
        cells = properties.setdefault(one.level, {})
        cells.setdefault(one.cell, {})[one.law] = Properties(margins, target)
    return properties
