"""The limits of the conditions on which laws are judged: units of work that no law changes."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.block import replace
from hydroservo.errors import ParameterError, ScenarioError
from hydroservo.limits.command import CommandLimits, command_limits, loosest
from hydroservo.limits.machine import check_limited, lawless, machine_limits
from hydroservo.loop import Loop
from hydroservo.runs.columns import SEED
from hydroservo.runs.provenance import scenario_text
from hydroservo.studies.asked import Study
from hydroservo.studies.cells import Entrant
from hydroservo.studies.standing import OF_LIMITS
from hydroservo.work.unit import Unit, address

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from hydroservo.work.store import Store

METRIC = "rms_error"  # the one that limits are of
DIGITS = 6  # that are kept: a search knows no more, and processors differ in those after


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
    command = loosest([one for entrant in entrants for one in commands(study, entrant)])
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
                found[number] = lawless(replace(entrant.contender.assemblies[kind].loop, own))
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
