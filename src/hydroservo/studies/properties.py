"""What no run says of a law in a cell: its margins, and its price on the target; units of work."""

import json
import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, NamedTuple, get_type_hints

import numpy as np

from hydroservo.audits.describing import busiest_instant, exact_sensors, freeze_loop
from hydroservo.control.loop import Loop
from hydroservo.core.block import replace
from hydroservo.core.errors import HydroservoError
from hydroservo.core.field import Field
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.linear import Margins, margins
from hydroservo.runs.provenance import canonical_toml
from hydroservo.studies.cells import LawInCell
from hydroservo.studies.fronts import level_name
from hydroservo.work.units import WorkUnit, unit_address

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from hydroservo.work.units import UnitStore

DIGITS = 5  # that are kept: behind them processors differ in their linear algebra
DOUBLE = 8  # bytes
ENDLESS = "has a loop that goes on as long as its numbers ask"
WORST = {"gain_margin": min, "gain_reduction_margin": max, "phase_margin": min, "delay_margin": min} | {
    "disk_margin": min,
    "sensitivity_peak": max,
}
COLUMN_KINDS = {int: "int64", int | None: "int64", float: "float64", bool: "bool_", str: "string"}
UNTRANSLATED = "says what is not in the language; export says what"


class LawMargins(NamedTuple):
    """The least margins of a law over operating points, as :class:`~hydroservo.linear.Margins` has them.

    They are nan where the loop is unstable at one of these points, or linear at none.
    """

    points: Annotated[int, Field("", "operating points that were looked at")]
    linear: Annotated[int, Field("", "how many of them the loop is linear about")]
    stable: Annotated[bool, Field("", "whether there is one, and it is stable at all of these")]
    gain_margin: Annotated[float, Field("", "least factor above 1 by which the gain makes it unstable")]
    gain_reduction_margin: Annotated[float, Field("", "largest factor below 1 by which it does")]
    phase_margin: Annotated[float, Field("rad", "least phase that makes it unstable")]
    delay_margin: Annotated[float, Field("s", "least delay that makes it unstable")]
    disk_margin: Annotated[float, Field("", "alpha of the smallest of the symmetric disks")]
    sensitivity_peak: Annotated[float, Field("", "largest |S|")]
    nonlinear: Annotated[str, Field("", "why it is not about the first other point; or empty")]


def law_margins(loops: Sequence[Loop]) -> LawMargins:
    """The least margins of a law's loop, with its valve's lag, its sensors' and its hold's, as it samples.

    The points are the machine at rest under 0 V, and for each loop the instant at which its demand and load
    are largest together; :func:`~hydroservo.audits.describing.freeze_loop` says how the machine moves there.

    Fails as :func:`~hydroservo.linear.margins`: it says nothing of large motions, and between the points
    margins can be less.
    """
    looks = [partial(margins_at_rest, loops[0]), *(partial(margins_at_busiest, loop) for loop in loops)]
    found, why = [], []
    for look in looks:
        try:
            with np.errstate(all="ignore"):
                found.append(look())
        except (HydroservoError, ArithmeticError, np.linalg.LinAlgError) as error:
            why.append(str(error))
    return least_margins(found)._replace(points=len(looks), nonlinear=why[0] if why else "")


def margins_at_rest(loop: Loop) -> Margins:
    return margins(loop._replace(sensors=exact_sensors(loop.sensors)), command=0.0)


def margins_at_busiest(loop: Loop) -> Margins:
    still = freeze_loop(loop, busiest_instant(loop))
    return margins(still.loop, command=still.command)


def least_margins(found: Sequence[Margins]) -> LawMargins:
    stable = bool(found) and all(one.stable for one in found)
    worst = {name: worse(getattr(one, name) for one in found) for name, worse in WORST.items() if stable}
    margins = {name: float(f"{worst.get(name, math.nan):.{DIGITS}g}") for name in WORST}
    return LawMargins(len(found), len(found), stable, **margins, nonlinear="")


class OnTarget(NamedTuple):
    """The price of a law on its target: what one sample takes at most, and how much memory.

    The numbers are those of :class:`~hydroservo.export.unit.Operations`, and None where there are none.
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


def target_price(loop: Loop) -> OnTarget:
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
    unit: WorkUnit


def property_units(entrants: Sequence[LawInCell], choice: "pd.DataFrame") -> Iterator[PropertyUnit]:
    """Each law in each cell at each level that it reaches, with the gains that it has there."""
    assemblies = {(one.cell.name, one.law.name): one.contender.assemblies.values() for one in entrants}
    columns = (choice[name].to_list() for name in ("level", "cell", "law", "parameters"))
    for level, cell, law, gains in zip(*columns, strict=True):
        loops = [replace(kind.loop, json.loads(gains)) for kind in assemblies[cell, law]]
        key = unit_address({"properties": [canonical_toml(loop) for loop in loops]})
        unit = WorkUnit(key, partial(properties_table, loops), f"margins of {law} in {cell}")
        yield PropertyUnit(level_name(level), cell, law, unit)


def properties_table(loops: Sequence[Loop]) -> "pa.Table":
    """The row of a law in a cell, from its loops for each kind of condition."""
    import pyarrow as pa

    row = {**law_margins(loops)._asdict(), **target_price(loops[0])._asdict()}
    kinds = get_type_hints(LawMargins) | get_type_hints(OnTarget)
    schema = pa.schema([(name, getattr(pa, COLUMN_KINDS[kind])()) for name, kind in kinds.items()])
    return pa.table({name: [value] for name, value in row.items()}, schema=schema)


def properties_in(
    store: "UnitStore", found: Sequence[PropertyUnit]
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
