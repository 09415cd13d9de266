"""What is fitted to what: a scenario and its logs as a problem of least squares."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import AUTO, Loop
from hydroservo.core.block import field_at, leaves, value_at
from hydroservo.core.errors import ScenarioError
from hydroservo.core.field import Field
from hydroservo.core.validation import within
from hydroservo.identification.experiment import (
    GIVEN,
    Experiment,
    experiment,
    first_steps,
    kernel_for,
    played_path,
)
from hydroservo.identification.observer import memory_rows
from hydroservo.identification.problem import Ends, Problem, Values, unknowns_of, usual_values
from hydroservo.identification.segments import Segment, UnderstoodLog, noise_of
from hydroservo.runs.tuning import SearchSpace, latin_hypercube
from hydroservo.scenario.datasheets import made_columns
from hydroservo.scenario.load import Assembly
from hydroservo.scenario.other_tables import Deviation
from hydroservo.scenario.parameter_draws import Variation, loop_parameters

FAR = 2.0  # times an uncertainty, up to which a number is sought
TRIED = 16  # points of the ranges, besides three on their diagonal, that show which numbers differ

FIRST = 12  # samples that show whether something moves
CLEAR = 3.0  # deviations of noise, from which a change is one


class FreedNumber(NamedTuple):
    """A number that is not sought but uncertain."""

    variation: Variation  # between which values it is freed
    share: float  # the part of that range that its uncertainty is


def uncertain_numbers(
    assembly: Assembly, varied: Sequence[Variation], but: Sequence[str]
) -> list[FreedNumber]:
    """The numbers of ``[uncertainty]`` that are not sought, each freed to twice as far where that may be.

    A number that follows from one that is sought, or from which one follows, is left out.
    """
    freed: list[FreedNumber] = []
    sought = {one.path for one in varied}
    for one in deviating_numbers(assembly):
        path = one.variation.path
        if path in sought or path.startswith(tuple(but)):
            continue
        if are_independent(assembly, [*varied, *(other.variation for other in freed), one.variation]):
            freed.append(one)
    return freed


def deviating_numbers(assembly: Assembly) -> Iterator[FreedNumber]:
    """The numbers whose ``[uncertainty]`` is not 0, twice as far to either side where that may be."""
    for path, one in {**assembly.truth.arguments, **assembly.truth.numbers}.items():
        if not isinstance(one, Deviation) or not one.relative:
            continue
        nominal, field = nominal_at(assembly, path)
        for times in (FAR, 1.0):
            low, high = sorted(nominal * (1.0 + sign * times * one.relative) for sign in (-1.0, 1.0))
            if (
                nominal not in (0.0, field.auto)
                and low * high > 0.0
                and within(low, field)
                and within(high, field)
            ):
                yield FreedNumber(Variation(path, low, high, nominal, one.entry), 1.0 / times)
                break


def nominal_at(assembly: Assembly, path: str) -> tuple[float, Field]:
    """The value of a number before its uncertainty, and its field."""
    argument = assembly.arguments.get(path)
    if argument is not None:
        return argument.value, argument.field
    head, _, inner = path.partition(".")
    return float(value_at(getattr(assembly.nominal, head), inner)), field_at(assembly.loop, path)


def are_independent(assembly: Assembly, varied: Sequence[Variation]) -> bool:
    """Whether no number follows from another one."""
    space = SearchSpace({one.path: (one.low, one.high) for one in varied})
    try:
        loop_parameters(assembly, varied, space.values(np.array([[0.4], [0.6]]).repeat(len(varied), axis=1)))
    except ScenarioError:
        return False
    return True


def fit_problem(
    assembly: Assembly,
    varied: Sequence[Variation],
    freed: Sequence[FreedNumber],
    taken: Sequence[UnderstoodLog],
    threads: int,
    delays: Ends = None,
) -> Problem:
    """What is fitted to what: numbers freed begin at their nominal values, delays lie in a range [s]."""
    known = assembly.arguments
    own = {
        path: known[path].value if path in known else float(value_at(assembly.loop, path))
        for path in [one.path for one in varied]
    }
    own |= {one.path: value for one, _ in freed if (value := one.nominal) is not None}
    varied = [*varied, *(one for one, _ in freed)]
    space = SearchSpace({one.path: (one.low, one.high) for one in varied})
    numbers = tuple(loop_parameters(assembly, varied, space.values(consistent_points(assembly, space))))
    constructed = [path for path in numbers if path in assembly.arguments or path not in space.ranges]
    columns, paths = partial(played_columns, assembly, varied, constructed), tuple(map(played_path, numbers))
    segments = [one for log in taken for one in log.segments]
    experiments = [segment_experiment(assembly.loop, segments, i, paths) for i in range(len(segments))]
    spread = signal_spreads(segments)
    unknowns = unknowns_of(space, experiments, spread, delays, {one.path: share for one, share in freed})
    usual = usual_values(own, space, unknowns)
    automatic = assembly.loop.simulation.substeps == AUTO
    return Problem(experiments, space, columns, unknowns, spread, usual, threads, delays, automatic)


def segment_experiment(loop: Loop, segments: Sequence[Segment], i: int, paths: Sequence[str]) -> Experiment:
    """A loop that plays a segment; where that begins in motion, states that no sensor shows are sought."""
    moving = begins_in_motion(segments, i)
    one = experiment(loop, segments[i], paths, first_steps(loop, segments[i]), moving)
    return with_unseen(one) if moving else one


def played_columns(
    assembly: Assembly, varied: Sequence[Variation], constructed: Sequence[str], values: Values
) -> Values:
    """The numbers that follow from some values of what is sought, by path in a loop that plays a segment."""
    columns = loop_parameters(assembly, varied, values, always=constructed)
    return {played_path(path): row for path, row in columns.items()}


def consistent_points(assembly: Assembly, space: SearchSpace) -> NDArray[np.float64]:
    """Points within ranges at which what constructors take goes together; all that were tried, if none."""
    count = len(space.ranges)
    diagonal = np.repeat([[0.5], [0.25], [0.75]], count, axis=1)
    points = np.concatenate([diagonal, latin_hypercube(TRIED, count, seed=0)])
    there = np.ones(len(points), dtype=bool)
    for i in range(len(points)):
        values = space.values(points[i : i + 1])
        try:
            made_columns(assembly, {path: row for path, row in values.items() if path in assembly.arguments})
        except ScenarioError:
            there[i] = False
    return points[there] if there.any() else points


def signal_spreads(segments: Sequence[Segment]) -> dict[tuple[int, str], float]:
    """The standard deviation of each log's signals."""
    rows: dict[tuple[int, str], list[NDArray[np.float64]]] = {}
    for one in segments:
        for name, values in one.measured.items():
            rows.setdefault((one.log, name), []).append(values)
    return {key: float(np.nanstd(np.concatenate(parts))) for key, parts in rows.items()}


def begins_in_motion(segments: Sequence[Segment], number: int) -> bool:
    """Whether a segment goes on after a gap, or its first samples show a velocity or a slope above noise."""
    own = segments[number]
    if any(one.log == own.log for one in segments[:number]):
        return True
    for name, values in own.measured.items():
        places = np.flatnonzero(np.isfinite(values))[:FIRST]
        if places.size < FIRST:
            continue
        slope, level = np.polyfit(places, values[places], 1)
        change = level if name == "velocity" else slope * places[-1]
        if abs(change) > CLEAR * noise_of(values):
            return True
    return False


def with_unseen(one: Experiment) -> Experiment:
    """The experiment with the states that its log does not show, and how far the machine moves them.

    A log that begins in motion, or goes on after a gap, begins with some velocity and some opening of its
    valve. States that stay where they are, or a machine that is lost, leave nothing to seek.
    """
    from hydroservo.engine.lanes import monitor_traces

    own = dict(leaves(one.loop))
    columns = {path: np.array([own[path]]) for path in one.varied if path in own}
    kernel, started = kernel_for(one, columns)
    paths = [path for path in one.varied if path.startswith(GIVEN) and path not in one.start]
    rows = memory_rows(kernel, [path.removeprefix(GIVEN) for path in paths])
    states: list[NDArray[np.float64]] = []
    monitor_traces(
        kernel,
        started,
        one.segment.samples,
        one.segment.period,
        lambda _, memory: states.append(memory[rows, 0].copy()),
    )
    sizes = np.std(states, axis=0)
    moved = zip(paths, sizes, strict=True) if np.isfinite(sizes).all() else ()
    return one._replace(unseen={path: (own[path], float(size)) for path, size in moved if size > 0.0})
