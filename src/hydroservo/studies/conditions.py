"""The conditions of a cell: drawn alike for every law, and another set for each purpose."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import field_at
from hydroservo.errors import ScenarioError
from hydroservo.runs.columns import SEED
from hydroservo.scenario.load import Assembly
from hydroservo.scenario.sampling import Variation, drawn, parameters_of, uniform, variation
from hydroservo.scenario.tables import Entry
from hydroservo.studies.asked import Conditions, Kind, Level, Study
from hydroservo.validation import allowed, within

SPLITS = ("train", "validation", "test", "stress")
MACHINE = ("plant.", "valve.", "supply.", "drive.")  # whose deviations are stressed: loads are none
LAW = "controller."
NOISE = 1_000_000  # seeds of noise between one split and the next

Numbers = NDArray[np.float64]


class Drawn(NamedTuple):
    """The conditions of one kind in one split.

    Attributes:
        numbers: of the conditions in their split.
        scales: on the deviations of the machine; nan but in the split stress.
        columns: by path in the loop, in SI units: what simulate_batch takes.
        changes: by path in a scenario, in SI units: what makes one of them alone.
    """

    numbers: NDArray[np.int64]
    scales: Numbers
    columns: Mapping[str, NDArray[Any]]
    changes: Mapping[str, NDArray[Any]]


def conditions_of(
    study: Study, levels: Sequence[Level], assemblies: Mapping[str, Assembly]
) -> dict[str, dict[str, Drawn]]:
    """The conditions of a cell by split and by kind.

    Each number is a function of the study's seed, its split, its path and the number of the condition alone,
    so that all laws meet the same ones, and no other law, cell or count changes them.

    Args:
        study: the study.
        levels: of the cell.
        assemblies: the loop of any law for each kind of condition.

    Source: Philox4x64-10, Salmon, Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405.
    """
    asked = study.conditions
    found: dict[str, dict[str, Drawn]] = {}
    for split in SPLITS:
        if split == "stress" and not asked.stress:
            continue
        found[split] = {
            kind.name: one_kind(study, split, i, varied(study, levels, kind), assemblies[kind.name])
            for i, kind in enumerate(asked.kinds)
        }
    check_apart(study, found)
    return {
        split: {name: one for name, one in own.items() if one.numbers.size} for split, own in found.items()
    }


def varied(study: Study, levels: Sequence[Level], kind: Kind) -> dict[str, Entry]:
    """What is drawn for the conditions of a kind, by path."""
    found = dict(study.conditions.vary)
    for level in levels:
        found |= level.vary
    found |= kind.vary
    for path, entry in found.items():
        if path.startswith(LAW):
            problem = "belongs to a law; conditions concern the machine, its load, demand and sensors"
            raise ScenarioError(entry.origin.name, entry.key, problem)
    return found


class Places(NamedTuple):
    """Which conditions of a split are of one kind.

    Attributes:
        numbers: in the split.
        source: the split whose draws they have: stress takes those of test.
        drawn: their numbers there.
        scales: on the deviations of the machine; nan but in the split stress.
    """

    numbers: NDArray[np.int64]
    source: str
    drawn: NDArray[np.int64]
    scales: Numbers


def places(asked: Conditions, split: str, which: int) -> Places:
    """Every so many conditions of a split, those of a kind."""
    if split != "stress":
        own = np.arange(which, asked.counts[split], len(asked.kinds))
        return Places(own, split, own, np.full(own.size, np.nan))
    own, scales = np.arange(which, asked.stressed, len(asked.kinds)), np.arange(len(asked.stress))
    numbers = (scales[:, np.newaxis] * asked.stressed + own).ravel()
    return Places(numbers, "test", np.tile(own, scales.size), np.repeat(asked.stress, own.size))


def one_kind(study: Study, split: str, which: int, ranges: Mapping[str, Entry], assembly: Assembly) -> Drawn:
    """The conditions of a split that are of one kind."""
    at = places(study.conditions, split, which)
    made = [variation(assembly, path, entry) for path, entry in ranges.items()]
    values = {}
    for one in made:
        stream = uniform(study.conditions.seed, f"{at.source} {one.path}", study.conditions.counts[at.source])
        values[one.path], deviation = drawn(one, stream[at.drawn])
        if split == "stress" and one.path.startswith(MACHINE) and deviation is not None:
            values[one.path] = stressed(study, one, assembly, at.scales * deviation)
    seeds = assembly.loop.simulation.seed + SPLITS.index(at.source) * NOISE + at.drawn
    columns = dict(parameters_of(assembly, made, values)) | {SEED: seeds}
    return Drawn(at.numbers, at.scales, columns, values | {SEED: seeds})


def stressed(study: Study, one: Variation, assembly: Assembly, deviation: Numbers) -> Numbers:
    """What a number of the machine is at some deviations."""
    found: Numbers = np.asarray(one.nominal) * (1.0 + deviation)
    field = (
        assembly.arguments[one.path].field
        if one.path in assembly.arguments
        else field_at(assembly.loop, one.path)
    )
    for value in (found.min(), found.max()) if found.size else ():
        if not within(float(value), field):
            problem = f"leads to {one.path} = {value:g}; it must be {allowed(field)}"
            raise ScenarioError(study.origin.name, "conditions.stress", problem)
    return found


def check_apart(study: Study, found: Mapping[str, Mapping[str, Drawn]]) -> None:
    """Refuse a condition that a law is judged by and was searched under."""
    seen: dict[tuple[object, ...], str] = {}
    for split in SPLITS[:3]:
        for kind, one in found[split].items():
            rows = [column.tolist() for path, column in one.changes.items() if path != SEED]
            for i, number in enumerate(one.numbers.tolist()):
                row = (kind, *(column[i] for column in rows))
                if seen.setdefault(row, split) != split:
                    problem = (
                        f"condition {number} is also one of {seen[row]}; let more vary in [conditions.vary]"
                    )
                    raise ScenarioError(study.origin.name, f"conditions.{split}", problem)
