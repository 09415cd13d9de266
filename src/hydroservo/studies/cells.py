"""The cells of a study's map, and the searches in each of them."""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from hydroservo.errors import ParameterError, ScenarioError
from hydroservo.loop import AUTO, Loop
from hydroservo.metrics import judged_by
from hydroservo.nearest import one_of
from hydroservo.runs.provenance import describe, scenario_text
from hydroservo.studies.asked import Law, Level, Study
from hydroservo.studies.contenders import Contender, contender
from hydroservo.studies.judging import Drawn, Group, Task, command_range, conditions_of
from hydroservo.studies.search import search_table
from hydroservo.work.unit import Unit, address

SLACK = 1.25  # beyond the first and the last level, that a search goes


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
