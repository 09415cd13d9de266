"""A study: laws, the conditions that they meet, and how their gains are searched."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.scenario.tables import FileOrigin, TableEntry


class ConditionKind(NamedTuple):
    """One way in which conditions differ, such as a kind of demand."""

    name: str
    changes: Mapping[str, Any]  # to the scenario, by dotted path
    vary: Mapping[str, TableEntry]  # what is drawn for each condition besides, by path


class AxisLevel(NamedTuple):
    """A value of an axis of the map: a kind with a place on it."""

    name: str
    label: str  # as pictures have it
    value: float | None  # where it lies on the axis, in a group without dimension; None where it has no place
    changes: Mapping[str, Any]  # to the scenario, by dotted path
    vary: Mapping[str, TableEntry]  # what is drawn for each condition besides, by path


class MapAxis(NamedTuple):
    """In what the cells of a map differ."""

    name: str
    label: str
    levels: Sequence[AxisLevel]


class ConditionPlan(NamedTuple):
    """What is drawn, and how often."""

    seed: int  # of all draws
    counts: Mapping[str, int]  # of the conditions in each split: train, validation, test
    # factors on the deviations of the machine in the split stress; none: no such split
    stress: Sequence[float]
    stressed: int  # conditions at each of them, the first ones of test
    vary: Mapping[str, TableEntry]  # what is drawn for each condition, by path
    kinds: Sequence[ConditionKind]  # which the conditions of a split take in turn


class SearchPlan(NamedTuple):
    """How the fronts of every law are searched."""

    candidates: int  # the most that one search tries
    seeds: int  # how many searches of each law there are
    step: float | None  # the longest integration step while searching [s]; None for those of the machine
    # activities of the command at which laws are compared, over that of the reference
    levels: Sequence[float]
    widen: int  # how often a range may be widened at whose end a point of the front lies


class ObserverChoice(NamedTuple):
    """An observer that laws are given in place of their own."""

    table: Mapping[str, Any]  # its type and what is not searched
    vary: Mapping[str, TableEntry]  # what is, by its own names
    drop: Sequence[str]  # paths beside it in the law that have no effect with it and are not searched


class LawSpec(NamedTuple):
    """A law, or one without a part."""

    name: str
    family: str  # of laws that are told apart by colour
    scenario: str | Path  # whose controller and ``[tune.vary]`` it has
    # to that controller, by path from the scenario's root; what they set is not searched
    changes: Mapping[str, Any]
    observer: str  # which it is given; "" for its own
    of: str  # the law that it is without a part; "" for one that is whole
    without: str  # that part, in words
    unwrapped: bool  # whether its outermost wrapper is left out
    wrapped: Mapping[str, Any]  # the table of a wrapper around it; empty for none


class StudySpec(NamedTuple):
    """A study: laws, the cells of a map, conditions in each of them, and how gains are searched."""

    title: str
    base: str | Path  # the scenario whose machine, sensors and sampling all laws have
    plugins: Sequence[Path]  # files with blocks of one's own
    changes: Mapping[str, Any]  # to that scenario, by dotted path
    metric: str  # what is compared
    reference: str  # the law that others are compared with
    # numbers of a law's blocks that are known, not tuned, as ``Type.field``, by what of the loop they are
    known: Mapping[str, TableEntry]
    laws: Mapping[str, LawSpec]  # by name
    observers: Mapping[str, ObserverChoice]  # by name
    axes: Sequence[MapAxis]  # of the map, in order
    conditions: ConditionPlan  # what is drawn
    search: SearchPlan  # how gains are searched
    limits: int  # test conditions whose limits are sought in each cell, the first ones
    origin: FileOrigin  # the file, for errors
