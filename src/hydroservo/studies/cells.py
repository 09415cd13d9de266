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
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.nearest import one_of
from hydroservo.limits.command import CommandLimits, command_limits, loosest_limits
from hydroservo.limits.least_error import check_limited, machine_limits, without_law
from hydroservo.runs.columns import SEED
from hydroservo.runs.provenance import describe, scenario_text
from hydroservo.studies.asked import Law, Level, Study
from hydroservo.studies.contenders import Contender, contender
from hydroservo.studies.judging import Drawn, Group, Task, command_range, conditions_of
from hydroservo.studies.search import search_table
from hydroservo.studies.standing import OF_LIMITS
from hydroservo.work.unit import Unit, address

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from hydroservo.work.store import Store

SLACK = 1.25  # beyond the first and the last level, that a search goes
METRIC = "rms_error"  # the one that limits are of
DIGITS = 6  # that are kept: a search knows no more, and processors differ in those after


class Cell(NamedTuple):
    """A combination of levels, one of each axis."""

    name: str
    levels: Sequence[Level]


class Entrant(NamedTuple):
    """A law in a cell, ready to be searched.

    Attributes:
        law: the law.
        cell: the cell.
        contender: its loops, and what of it is searched.
        drawn: the conditions, by split and by kind.
    """

    law: Law
    cell: Cell
    contender: Contender
    drawn: Mapping[str, Mapping[str, Drawn]]


def cells_of(study: Study) -> list[Cell]:
    """The cells of a map, its last axis running fastest; one cell named all where there are no axes."""
    levels = product(*(axis.levels for axis in study.axes))
    cells = [Cell("-".join(level.name for level in one) or "all", one) for one in levels]
    names = [cell.name for cell in cells]
    for name in names:
        if names.count(name) > 1:
            raise ScenarioError(study.origin.name, "axes", f"two cells are named {name}; rename a level")
    return cells


def entrants_of(study: Study) -> Iterator[Entrant]:
    """Each law in each cell."""
    for cell in cells_of(study):
        laws = [(law, fitting(study, law, cell)) for law in study.laws.values()]
        drawn = conditions_of(study, cell.levels, laws[0][1].assemblies)
        for law, one in laws:
            yield Entrant(law, cell, one, drawn)


def fitting(study: Study, law: Law, cell: Cell) -> Contender:
    """A law in a cell, its loops as a study can hold them against others."""
    try:
        found = contender(study, law, cell.levels)
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


def units_of(study: Study, entrant: Entrant, activity: float | None) -> Iterator[Unit]:
    """The searches of a law in a cell.

    Args:
        study: the study.
        entrant: the law there.
        activity: of the reference there, of the training conditions; None for the reference.
    """
    groups = [
        Group(
            one.loop,
            coarse(one.loop, study.search.step),
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
    about = [about_group(group) for group in groups]
    for seed in range(search.seeds):
        asked = (law, cell, seed, study.metric, search.candidates, search.widen, calmest, window)
        task = Task(*asked, ranges, groups)
        key = address(
            {
                "task": list(asked),
                "ranges": {path: list(ends) for path, ends in ranges.items()},
                "groups": about,
            }
        )
        yield Unit(key, partial(search_table, task), f"{law} in {cell}, search {seed}")


def coarse(loop: Loop, step: float | None) -> Loop:
    """A loop with integration steps as long as they may be [s], and no shorter ones than it has."""
    simulation = loop.simulation
    if step is None or isinstance(simulation.substeps, str):
        return loop
    few = max(1, math.ceil(simulation.period / step - 1e-9))
    return loop._replace(simulation=simulation._replace(substeps=min(few, simulation.substeps)))


def about_group(group: Group) -> dict[str, Any]:
    """What a group is, as text."""
    judges = describe(group.loop.metrics)
    return {
        "loop": scenario_text(group.loop),
        "substeps": group.coarse.simulation.substeps,
        "judges": json.dumps(judges),
        "drawn": {split: about_drawn(one) for split, one in group.drawn.items()},
    }


def about_drawn(drawn: Drawn) -> str:
    """A digest of the bits of conditions."""
    digest = hashlib.sha256()
    arrays = {"numbers": drawn.numbers, "scales": drawn.scales, **dict(sorted(drawn.columns.items()))}
    for name, values in arrays.items():
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(values, dtype=np.float64).tobytes())
    return digest.hexdigest()


class Limited(NamedTuple):
    """A test condition of a cell, and the unit that seeks its limits."""

    cell: str
    condition: int
    unit: Unit


def limited(study: Study, entrants: Sequence[Entrant]) -> list[Limited]:
    """The first test conditions of each cell, as many as a study asks limits of.

    Cells that differ in sensors alone have the same limits, and the same units.
    """
    if not study.limits:
        return []
    if study.metric != METRIC:
        problem = f"is for the metric {METRIC}, and this study's is {study.metric}"
        raise ScenarioError(study.origin.name, "limits", problem)
    return [one for _, own in groupby(entrants, cell_name) for one in in_cell(study, list(own))]


def cell_name(entrant: Entrant) -> str:
    return entrant.cell.name


def in_cell(study: Study, entrants: Sequence[Entrant]) -> Iterator[Limited]:
    """The limited conditions of a cell, in which all of its laws are."""
    cell = entrants[0].cell.name
    command = loosest_limits([one for entrant in entrants for one in commands(study, entrant)])
    loops = loops_under(entrants[0], study.limits)
    try:
        check_limited(loops[0])
    except ParameterError as error:
        raise ScenarioError(study.origin.name, "limits", f"cannot be sought in {cell}: {error}") from None
    for number, loop in sorted(loops.items()):
        key = address({"limit": scenario_text(loop), "command": repr(command)})
        yield Limited(cell, number, Unit(key, partial(found_by, loop, command), f"limit {number} of {cell}"))


def commands(study: Study, entrant: Entrant) -> Iterator[CommandLimits]:
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


def loops_under(entrant: Entrant, count: int) -> dict[int, Loop]:
    """The loop of a cell under each of the first test conditions, without the law."""
    found = {}
    for kind, drawn in entrant.drawn["test"].items():
        for i, number in enumerate(drawn.numbers.tolist()):
            if number < count:
                own = {path: float(column[i]) for path, column in drawn.columns.items() if path != SEED}
                found[number] = without_law(replace(entrant.contender.assemblies[kind].loop, own))
    return found


def found_by(loop: Loop, command: CommandLimits) -> "pa.Table":
    """The row of one condition."""
    import pyarrow as pa

    found = machine_limits(loop, command)
    errors = {name: [rounded(getattr(found, name))] for name in ("clairvoyant", "causal")}
    return pa.table({**errors, "converged": [found.converged]})


def rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def table_of_limits(found: Sequence[Limited], store: "Store") -> "pd.DataFrame":
    """A row for each condition whose limits are done."""
    import pandas as pd

    if not found:
        return pd.DataFrame(columns=OF_LIMITS)
    table: pd.DataFrame = store.table([one.unit.key for one in found]).to_pandas()
    table.insert(0, "condition", [one.condition for one in found])
    table.insert(0, "cell", [one.cell for one in found])
    return table
