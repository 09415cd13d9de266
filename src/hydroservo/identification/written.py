"""What was found, as tables of a scenario over the one that was fitted."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hydroservo.block import leaves
from hydroservo.errors import HydroservoError, ScenarioError
from hydroservo.identification.result import Estimate
from hydroservo.scenario.layers import nested
from hydroservo.scenario.load import Assembly, Machine, assembled
from hydroservo.scenario.truth import Value

CLOSE = 1e-9  # relative difference that digits may make

Changes = Mapping[str, object]


def tables_with(
    source: str | Path,
    changes: Changes,
    plugins: Sequence[str | Path],
    found: Mapping[str, Estimate],
) -> dict[str, Any]:
    """The tables of a scenario with what was found as its machine, and its uncertainty from the covariance.

    ``[uncertainty]`` holds half the width of each 95 % interval that the logs tell, relative to the value, at
    scale 0: a run is with the values found, and ``--set uncertainty.scale=1`` goes to the interval's end.
    What the scenario had there before counts in ``[truth]`` from now on. A number that a constructor computes
    cannot stand beside what it computes it from, and goes into ``[truth]`` too, in which the law does not
    believe.
    """
    before = assembled(source, changes, plugins)
    values = {path: one.value for path, one in found.items()}
    own: dict[str, Any] = dict(changes)
    for path, value in values.items():
        own |= {place_of(source, own, plugins, path, value): value}
    own |= truths(before, values, own)
    own |= uncertainties(found, own)
    check(assembled(source, own, plugins), before, values)
    return nested(own)


def tables_or_remark(
    source: str | Path,
    changes: Changes,
    plugins: Sequence[str | Path],
    found: Mapping[str, Estimate],
) -> tuple[dict[str, Any], list[str]]:
    """What :func:`tables_with` gives, or the tables there were and why: no problem must cost a result."""
    try:
        return tables_with(source, changes, plugins, found), []
    except HydroservoError as error:
        return nested(changes), [f"the scenario is written without what was found: {error}"]


def place_of(
    source: str | Path, changes: Changes, plugins: Sequence[str | Path], path: str, value: float
) -> str:
    """Where a value can be said: at its own path, or as a truth where a constructor computes the number."""
    try:
        assembled(source, {**changes, path: value}, plugins)
    except ScenarioError:
        return f"truth.{path}"
    return path


def truths(before: Assembly, values: Mapping[str, float], own: Changes) -> dict[str, float]:
    """What the scenario's uncertainty made of other numbers, and what must outdo a truth of it."""
    loop, said = dict(leaves(before.loop)), {**before.truth.arguments, **before.truth.numbers}
    taken = {
        f"{name}.{path}": value
        for name in Machine._fields
        for path, value in before.truth.taken(name, before.arguments).items()
    }
    kept = {path: float(taken.get(path, loop.get(path, 0.0))) for path in said if path not in values}
    outdone = {path: value for path, value in values.items() if isinstance(said.get(path), Value)}
    return {f"truth.{path}": value for path, value in (kept | outdone).items() if f"truth.{path}" not in own}


def uncertainties(found: Mapping[str, Estimate], own: Changes) -> dict[str, float]:
    """Relative deviations of what the logs tell, at scale 0."""
    relative = {
        f"uncertainty.{path}": 0.5 * (one.high - one.low) / abs(one.value)
        for path, one in found.items()
        if one.identifiable and one.value and f"truth.{path}" not in own
    }
    return {"uncertainty.scale": 0.0, **relative}


def check(written: Assembly, before: Assembly, values: Mapping[str, float]) -> None:
    """Refuse to write what is not the machine found."""
    told = dict(leaves(Machine(*(getattr(written.loop, name) for name in Machine._fields))))
    old = dict(leaves(Machine(*(getattr(before.loop, name) for name in Machine._fields))))
    for path, value in values.items():
        if path in told and abs(told[path] - value) > CLOSE * abs(value):
            raise HydroservoError(
                f"{path}: a scenario cannot give {value:g} here; it would be {told[path]:g}"
            )
    if not before.arguments.keys() & values.keys():
        for path in told.keys() - values.keys():
            if isinstance(told[path], float) and abs(told[path] - old[path]) > CLOSE * abs(old[path]):
                raise HydroservoError(
                    f"{path}: follows from what was found, and cannot be written as a scenario"
                )
