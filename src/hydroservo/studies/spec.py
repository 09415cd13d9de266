"""A study: laws, the conditions that they meet, and how their gains are searched."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.scenario.tables import FileOrigin, TableEntry


class ConditionKind(NamedTuple):
    """One way in which conditions differ, such as a kind of demand.

    Attributes:
        name: its own.
        changes: to the scenario, by dotted path.
        vary: what is drawn for each condition besides, by path.
    """

    name: str
    changes: Mapping[str, Any]
    vary: Mapping[str, TableEntry]


class AxisLevel(NamedTuple):
    """A value of an axis of the map: a kind with a place on it.

    Attributes:
        name: its own.
        label: as pictures have it.
        value: where it lies on the axis, in a group without dimension; None where it has no place.
        changes: to the scenario, by dotted path.
        vary: what is drawn for each condition besides, by path.
    """

    name: str
    label: str
    value: float | None
    changes: Mapping[str, Any]
    vary: Mapping[str, TableEntry]


class MapAxis(NamedTuple):
    """In what the cells of a map differ."""

    name: str
    label: str
    levels: Sequence[AxisLevel]


class ConditionPlan(NamedTuple):
    """What is drawn, and how often.

    Attributes:
        seed: of all draws.
        counts: of the conditions in each split: train, validation, test.
        stress: factors on the deviations of the machine in the split stress; none: no such split.
        stressed: conditions at each of them, the first ones of test.
        vary: what is drawn for each condition, by path.
        kinds: which the conditions of a split take in turn.
    """

    seed: int
    counts: Mapping[str, int]
    stress: Sequence[float]
    stressed: int
    vary: Mapping[str, TableEntry]
    kinds: Sequence[ConditionKind]


class SearchPlan(NamedTuple):
    """How the fronts of every law are searched.

    Attributes:
        candidates: the most that one search tries.
        seeds: how many searches of each law there are.
        step: the longest integration step while searching [s]; None for those of the machine.
        levels: activities of the command at which laws are compared, over that of the reference.
        widen: how often a range may be widened at whose end a point of the front lies.
    """

    candidates: int
    seeds: int
    step: float | None
    levels: Sequence[float]
    widen: int


class ObserverChoice(NamedTuple):
    """An observer that laws are given in place of their own.

    Attributes:
        table: its type and what is not searched.
        vary: what is, by its own names.
        drop: paths beside it in the law that have no effect with it and are not searched.
    """

    table: Mapping[str, Any]
    vary: Mapping[str, TableEntry]
    drop: Sequence[str]


class LawSpec(NamedTuple):
    """A law, or one without a part.

    Attributes:
        name: its own.
        family: of laws that are told apart by colour.
        scenario: whose controller and ``[tune.vary]`` it has.
        changes: to that controller, by path from the scenario's root; what they set is not searched.
        observer: which it is given; "" for its own.
        of: the law that it is without a part; "" for one that is whole.
        without: that part, in words.
        unwrapped: whether its outermost wrapper is left out.
        wrapped: the table of a wrapper around it; empty for none.
    """

    name: str
    family: str
    scenario: str | Path
    changes: Mapping[str, Any]
    observer: str
    of: str
    without: str
    unwrapped: bool
    wrapped: Mapping[str, Any]


class StudySpec(NamedTuple):
    """A study: laws, the cells of a map, conditions in each of them, and how gains are searched.

    Attributes:
        title: its own.
        base: the scenario whose machine, sensors and sampling all laws have.
        plugins: files with blocks of one's own.
        changes: to that scenario, by dotted path.
        metric: what is compared.
        reference: the law that others are compared with.
        known: numbers of a law's blocks that are not tuned but known, as ``Type.field``, by what of the loop
            they are.
        laws: by name.
        observers: by name.
        axes: of the map, in order.
        conditions: what is drawn.
        search: how gains are searched.
        limits: test conditions whose limits are sought in each cell, the first ones.
        origin: the file, for errors.
    """

    title: str
    base: str | Path
    plugins: Sequence[Path]
    changes: Mapping[str, Any]
    metric: str
    reference: str
    known: Mapping[str, TableEntry]
    laws: Mapping[str, LawSpec]
    observers: Mapping[str, ObserverChoice]
    axes: Sequence[MapAxis]
    conditions: ConditionPlan
    search: SearchPlan
    limits: int
    origin: FileOrigin
