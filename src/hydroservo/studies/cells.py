"""The cells of a study's map, the searches in each of them, and the limits of their conditions."""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import groupby, product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydroservo.control.loop import AUTO, Loop
from hydroservo.control.metrics import judged_by
from hydroservo.core.block import replace
from hydroservo.core.errors import ParameterError, ScenarioError, one_of
from hydroservo.limits.command import CommandLimits, command_limits, loosest_limits
from hydroservo.limits.least_error import check_limited, machine_limits, without_law
from hydroservo.runs.columns import SEED
from hydroservo.runs.provenance import block_tables, canonical_toml
from hydroservo.studies.conditions import (
    ConditionGroup,
    DrawnConditions,
    SearchTask,
    command_range,
    draw_conditions,
)
from hydroservo.studies.law_standing import OF_LIMITS
from hydroservo.studies.laws import TunableLaw, tunable_law
from hydroservo.studies.search import search_table
from hydroservo.studies.spec import AxisLevel, LawSpec, StudySpec
from hydroservo.work.units import WorkUnit, unit_address

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from hydroservo.work.units import UnitStore

SLACK = 1.25  # beyond the first and the last level, that a search goes
METRIC = "rms_error"  # the one that limits are of
DIGITS = 6  # that are kept: a search knows no more, and processors differ in those after


class MapCell(NamedTuple):
    """A combination of levels, one of each axis."""

    name: str
    levels: Sequence[AxisLevel]


class LawInCell(NamedTuple):
    """A law in a cell, ready to be searched."""

    law: LawSpec  # the law
    cell: MapCell  # the cell
    contender: TunableLaw  # its loops, and what of it is searched
    drawn: Mapping[str, Mapping[str, DrawnConditions]]  # the conditions, by split and by kind


def map_cells(study: StudySpec) -> list[MapCell]:
    """The cells of a map, its last axis running fastest; one cell named all where there are no axes."""
    levels = product(*(axis.levels for axis in study.axes))
    cells = [MapCell("-".join(level.name for level in one) or "all", one) for one in levels]
    names = [cell.name for cell in cells]
    for name in names:
        if names.count(name) > 1:
            raise ScenarioError(study.origin.name, "axes", f"two cells are named {name}; rename a level")
    return cells


def laws_in_cells(study: StudySpec) -> Iterator[LawInCell]:
    for cell in map_cells(study):
        laws = [(law, comparable_law(study, law, cell)) for law in study.laws.values()]
        drawn = draw_conditions(study, cell.levels, laws[0][1].assemblies)
        for law, one in laws:
            yield LawInCell(law, cell, one, drawn)


def comparable_law(study: StudySpec, law: LawSpec, cell: MapCell) -> TunableLaw:
    """A law in a cell, its loops as a study can hold them against others."""
    try:
        found = tunable_law(study, law, cell.levels)
    except ParameterError as error:
        raise ScenarioError(study.origin.name, f"laws.{law.name}", str(error)) from None
    for one in found.assemblies.values():
        known = judged_by([one.loop])
        if study.metric not in known:
            raise ScenarioError(
                study.origin.name, "metric", f"{study.metric!r} {one_of(study.metric, known)}"
            )
        if one.loop.simulation.substeps == AUTO:
            problem = "must be a number, the same for all laws, such as set.simulation.substeps = 10"
            raise ScenarioError(study.origin.name, "simulation.substeps", problem)
        try:
            command_range(one.loop)
        except ParameterError as error:
            raise ScenarioError(study.origin.name, f"laws.{law.name}", str(error)) from None
    return found


def search_units(study: StudySpec, entrant: LawInCell, activity: float | None) -> Iterator[WorkUnit]:
    groups = [
        ConditionGroup(
            one.loop,
            with_search_steps(one.loop, study.search.step),
            {split: own[kind] for split, own in entrant.drawn.items() if kind in own},
        )
        for kind, one in entrant.contender.assemblies.items()
    ]
    search, ranges = study.search, entrant.contender.ranges
    law, cell = entrant.law.name, entrant.cell.name
    calmest, liveliest = search.levels[0] / SLACK, search.levels[-1] * SLACK
    window = None
    if activity is not None:
        window = math.log(calmest * activity), math.log(liveliest * activity)
    about = [group_identity(group) for group in groups]
    for seed in range(search.seeds):
        asked = (law, cell, seed, study.metric, search.candidates, search.widen, calmest, window)
        task = SearchTask(*asked, ranges, groups)
        key = unit_address(
            {
                "task": list(asked),
                "ranges": {path: list(ends) for path, ends in ranges.items()},
                "groups": about,
            }
        )
        yield WorkUnit(key, partial(search_table, task), f"{law} in {cell}, search {seed}")


def with_search_steps(loop: Loop, step: float | None) -> Loop:
    """A loop with integration steps as long as they may be [s], and no shorter ones than it has."""
    simulation = loop.simulation
    if step is None or isinstance(simulation.substeps, str):
        return loop
    few = max(1, math.ceil(simulation.period / step - 1e-9))
    return loop._replace(simulation=simulation._replace(substeps=min(few, simulation.substeps)))


def group_identity(group: ConditionGroup) -> dict[str, Any]:
    judges = block_tables(group.loop.metrics)
    return {
        "loop": canonical_toml(group.loop),
        "substeps": group.coarse.simulation.substeps,
        "judges": json.dumps(judges),
        "drawn": {split: conditions_digest(one) for split, one in group.drawn.items()},
    }


def conditions_digest(drawn: DrawnConditions) -> str:
    digest = hashlib.sha256()
    arrays = {"numbers": drawn.numbers, "scales": drawn.scales, **dict(sorted(drawn.columns.items()))}
    for name, values in arrays.items():
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(values, dtype=np.float64).tobytes())
    return digest.hexdigest()


class LimitedCondition(NamedTuple):
    """A test condition of a cell, and the unit that seeks its limits."""

    cell: str
    condition: int
    unit: WorkUnit


def limited_conditions(study: StudySpec, entrants: Sequence[LawInCell]) -> list[LimitedCondition]:
    """The first test conditions of each cell, as many as a study asks limits of.

    Cells that differ in sensors alone have the same limits, and the same units.
    """
    if not study.limits:
        return []
    if study.metric != METRIC:
        problem = f"is for the metric {METRIC}, and this study's is {study.metric}"
        raise ScenarioError(study.origin.name, "limits", problem)
    by_cell = groupby(entrants, lambda entrant: entrant.cell.name)
    return [one for _, own in by_cell for one in limited_in_cell(study, list(own))]


def limited_in_cell(study: StudySpec, entrants: Sequence[LawInCell]) -> Iterator[LimitedCondition]:
    """The limited conditions of a cell, in which all of its laws are."""
    cell = entrants[0].cell.name
    command = loosest_limits([one for entrant in entrants for one in law_command_limits(study, entrant)])
    loops = loops_under_conditions(entrants[0], study.limits)
    try:
        check_limited(loops[0])
    except ParameterError as error:
        raise ScenarioError(study.origin.name, "limits", f"cannot be sought in {cell}: {error}") from None
    for number, loop in sorted(loops.items()):
        key = unit_address({"limit": canonical_toml(loop), "command": repr(command)})
        yield LimitedCondition(
            cell, number, WorkUnit(key, partial(limit_row, loop, command), f"limit {number} of {cell}")
        )


def law_command_limits(study: StudySpec, entrant: LawInCell) -> Iterator[CommandLimits]:
    """What limits the command of a law, with each kind of condition."""
    key = f"laws.{entrant.law.name}"
    for one in entrant.contender.assemblies.values():
        try:
            found = command_limits(one.loop)
        except ParameterError as error:
            raise ScenarioError(study.origin.name, key, str(error)) from None
        for path, ends in entrant.contender.ranges.items():
            if any(command_limits(replace(one.loop, {path: end})) != found for end in ends):
                problem = f"searches {path}, which limits its command; set it, so that the study has [limits]"
                raise ScenarioError(study.origin.name, key, problem)
        yield found


def loops_under_conditions(entrant: LawInCell, count: int) -> dict[int, Loop]:
    """The loop of a cell under each of the first test conditions, without the law."""
    found = {}
    for kind, drawn in entrant.drawn["test"].items():
        for i, number in enumerate(drawn.numbers.tolist()):
            if number < count:
                own = {path: float(column[i]) for path, column in drawn.columns.items() if path != SEED}
                found[number] = without_law(replace(entrant.contender.assemblies[kind].loop, own))
    return found


def limit_row(loop: Loop, command: CommandLimits) -> "pa.Table":
    import pyarrow as pa

    found = machine_limits(loop, command)
    errors = {name: [float(f"{getattr(found, name):.{DIGITS}g}")] for name in ("clairvoyant", "causal")}
    return pa.table({**errors, "converged": [found.converged]})


def table_of_limits(found: Sequence[LimitedCondition], store: "UnitStore") -> "pd.DataFrame":
    """A row for each condition whose limits are done."""
    import pandas as pd

    if not found:
        return pd.DataFrame(columns=OF_LIMITS)
    table: pd.DataFrame = store.table([one.unit.key for one in found]).to_pandas()
    table.insert(0, "condition", [one.condition for one in found])
    table.insert(0, "cell", [one.cell for one in found])
    return table
