"""The residuals of logs as a function of all that is unknown: parameters, and how each log was taken."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.identification.experiment import (
    BEGUN,
    GIVEN,
    Experiment,
    automatic_steps,
    predict_traces,
    run_columns,
    with_experiment_steps,
)
from hydroservo.identification.log import OUTPUTS
from hydroservo.identification.observer import shift_signals, slope_of_shift
from hydroservo.identification.segments import Segment
from hydroservo.runs.columns import Columns
from hydroservo.runs.tuning import SearchSpace

STEP = 3e-4  # of a parameter's range, for its central difference
UNCERTAIN_STEP = 3e-3  # of the narrower range of a parameter that is not sought
START_STEP = 1e-3  # of a signal's spread, for a state's at the start
DELAY = "delay"  # as a range has it
DELAY_STEP = 0.05  # of a period
LONGEST_DELAY = 1.0  # [s]
SHARE = 0.1  # of a log's samples, which a delay is at most, unless its range is given
EARLIEST = 1.5  # periods by which a machine may seem to answer before it is asked
FAR = 10.0  # spreads, up to which an offset or a start is sought
END = 0.005  # of a range, within which a value lies at its end
PLACES = {name: i for i, name in enumerate(OUTPUTS)}  # of a signal, in what is predicted

Vector = NDArray[np.float64]
Values = Mapping[str, Vector]
Ends = tuple[float, float] | None


class UnknownNumber(NamedTuple):
    """One number that is sought."""

    name: str  # of a parameter its path; else what it is of, for people
    kind: str  # "parameter", "uncertain" (a parameter that is not sought), "start", "delay" or "offset"
    where: int  # of a start the segment's number, of a delay or an offset the log's; of a parameter -1
    key: str  # its path, or the signal of an offset
    scale: float  # SI units per unit of the search; of a parameter 1, for it is sought in its range as 0 to 1
    low: float  # the least that it may be, in units of the search
    high: float  # the most
    share: float = 1.0  # the part of that range over which it is taken as even before anything is measured

    @property
    def prior(self) -> float:
        """The precision of an even distribution over its share of the range."""
        return 12.0 / (self.share * (self.high - self.low)) ** 2


class Problem(NamedTuple):
    """What is fitted to what."""

    experiments: Sequence[Experiment]  # one for each segment
    space: SearchSpace  # the ranges of the parameters
    # the numbers that follow from parameters, by path in a loop that plays a segment, in SI units
    columns: Callable[[Values], Mapping[str, Vector]]
    unknowns: Sequence[UnknownNumber]  # all that is sought, the parameters first
    spread: Mapping[tuple[int, str], float]  # of each signal of each log, by log and name, in its unit
    usual: Vector  # where the search begins, shape (unknowns,)
    threads: int  # how many to use
    delays: Ends = None  # least and largest delay of a log [s]; None for the default range
    automatic: bool = False  # whether the number of integration steps adapts to the machine
    pinned: bool = False  # whether numbers that are uncertain but not sought stay where they are

    @property
    def uncertain(self) -> dict[str, float]:
        """The shares of parameters that are not sought, but freed within their uncertainty, by path."""
        return {one.key: one.share for one in self.unknowns if one.kind == "uncertain"}

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """The least and the most of each unknown."""
        return np.array([one.low for one in self.unknowns]), np.array([one.high for one in self.unknowns])


class SimulatedSegment(NamedTuple):
    """A segment as the machine would have shown it."""

    values: Values  # by signal, with its offset, shape (n,)
    slopes: Values  # by signal, by each unknown, shape (n, unknowns)


def unknowns_of(
    space: SearchSpace,
    experiments: Sequence[Experiment],
    spread: Mapping[tuple[int, str], float],
    delays: Ends = None,
    uncertain: Mapping[str, float] | None = None,
) -> list[UnknownNumber]:
    """All that is sought: parameters, each segment's start, each log's delay and its sensors' offsets.

    A position has no offset: where its zero is and where the piston starts are the same to a machine.
    """
    shares = uncertain or {}
    kinds = {path: "uncertain" if path in shares else "parameter" for path in space.ranges}
    found = [
        UnknownNumber(path, kind, -1, path, 1.0, 0.0, 1.0, shares.get(path, 1.0))
        for path, kind in kinds.items()
    ]
    for i, one in enumerate(experiments):
        for path in one.start:
            signal = path.rpartition(".")[2]
            scale = spread[one.segment.log, signal]
            at = one.start[path] / scale
            name = f"{signal} at {one.segment.start:g} s"
            found.append(UnknownNumber(name, "start", i, path, scale, at - FAR, at + FAR))
        for path, (value, scale) in one.unseen.items():
            name, at = f"{path.removeprefix(GIVEN)} at {one.segment.start:g} s", value / scale
            found.append(UnknownNumber(name, "start", i, path, scale, at - FAR, at + FAR))
    for log in dict.fromkeys(one.segment.log for one in experiments):
        own = (one.segment for one in experiments if one.segment.log == log)
        segment = max(own, key=lambda stretch: stretch.samples)
        found.append(UnknownNumber("delay", "delay", log, BEGUN, segment.period, *delays_of(segment, delays)))
        found += [
            UnknownNumber(f"offset of {name}", "offset", log, name, spread[log, name], -FAR, FAR)
            for name in segment.measured
            if name != "position"
        ]
    return found


def delays_of(segment: Segment, delays: Ends) -> tuple[float, float]:
    """The samples between which the delay of a log is sought, by its longest segment."""
    if delays is None:
        return -EARLIEST, min(LONGEST_DELAY / segment.period, SHARE * segment.samples)
    least, most = (one / segment.period for one in delays)
    lasts = segment.samples - 1
    if least >= lasts:
        longest_stretch = f"{lasts * segment.period:g} s, the length of the log's longest stretch"
        wanted = f"must begin below {longest_stretch} without a gap"
        raise ParameterError(DELAY, delays[0], wanted)
    return least, min(most, float(lasts))


def simulate_segments(problem: Problem, x: Vector, slopes: bool = True) -> list[SimulatedSegment]:
    """All segments at a point, with the slopes by every unknown.

    All differences of a segment's slopes are lanes of one batch. Beside an end of its range, and beside a
    point that allows no machine, they are to one side.
    """
    return [simulate_segment(problem, i, x, slopes) for i in range(len(problem.experiments))]


def simulate_segment(problem: Problem, number: int, x: Vector, slopes: bool) -> SimulatedSegment:
    one = problem.experiments[number]
    log, signals = one.segment.log, list(one.segment.measured)
    moved = [
        i
        for i, unknown in enumerate(problem.unknowns)
        if slopes
        and concerns(problem, unknown, number)
        and not (problem.pinned and unknown.kind == "uncertain")
    ]
    points = nudged_points(problem, x, moved)
    try:
        shown = runs_at(problem, points, number)
    except (ParameterError, ScenarioError):
        points[~are_possible(problem, points)] = x
        shown = runs_at(problem, points, number)
    apart = np.array([points[1 + 2 * k, i] - points[2 + 2 * k, i] for k, i in enumerate(moved)])
    apart[apart == 0.0] = np.inf
    shown = shown[:, [PLACES[name] for name in signals], :]
    slopes_of = np.zeros((one.segment.samples, len(signals), x.size))
    slopes_of[:, :, moved] = (shown[:, :, 1::2] - shown[:, :, 2::2]) / apart
    late = delay_of(problem, log)
    table = shift_signals(slopes_of, x[late], one.whole)
    if slopes:
        table[:, :, late] += slope_of_shift(shown[:, :, 0], x[late], one.whole)
    own = shift_signals(shown[:, :, 0], x[late], one.whole)
    values = {name: own[:, j] for j, name in enumerate(signals)}
    found = {name: table[:, j] for j, name in enumerate(signals)}
    for i, unknown in enumerate(problem.unknowns):
        if unknown.kind == "offset" and unknown.where == log:
            values[unknown.key] += unknown.scale * x[i]
            found[unknown.key][:, i] += unknown.scale
    return SimulatedSegment(values, found)


def delay_of(problem: Problem, log: int) -> int:
    """Which unknown the delay of a log is."""
    return next(i for i, one in enumerate(problem.unknowns) if one.kind == "delay" and one.where == log)


def concerns(problem: Problem, unknown: UnknownNumber, segment: int) -> bool:
    """Whether a segment must be simulated again where an unknown changes."""
    one = problem.experiments[segment]
    own = unknown.where == one.segment.log
    followed = own and one.observer is not None
    late = own and unknown.key in one.varied
    of = {"start": unknown.where == segment, "delay": followed or late, "offset": followed}
    return of.get(unknown.kind, True)


def nudged_points(problem: Problem, x: Vector, moved: Sequence[int]) -> Vector:
    """The point, then beyond and short of it in each unknown that is moved; inside its range."""
    low, high = problem.bounds
    points = np.repeat(x[np.newaxis], 1 + 2 * len(moved), axis=0)
    steps = {"uncertain": UNCERTAIN_STEP, "start": START_STEP, "offset": START_STEP, "delay": DELAY_STEP}
    for k, i in enumerate(moved):
        step = steps.get(problem.unknowns[i].kind, STEP)
        for row, sign in ((1 + 2 * k, 1.0), (2 + 2 * k, -1.0)):
            points[row, i] = min(max(x[i] + sign * step, low[i]), high[i])
    return points


def are_possible(problem: Problem, points: Vector) -> NDArray[np.bool_]:
    """Which points of shape (points, unknowns) allow a machine that can start in every segment."""
    try:
        for number, one in enumerate(problem.experiments):
            run_columns(one, columns_at(problem, points, number))
    except (ParameterError, ScenarioError):
        if len(points) == 1:
            return np.zeros(1, dtype=bool)
        return np.concatenate([are_possible(problem, part) for part in np.array_split(points, 2)])
    return np.ones(len(points), dtype=bool)


def columns_at(problem: Problem, points: Vector, segment: int) -> Columns:
    """What the runs of a segment do not share, at points of shape (runs, unknowns)."""
    count, known = len(problem.space.ranges), problem.experiments[segment].varied
    every = problem.columns(problem.space.values(points[:, :count]))
    found = {path: values for path, values in every.items() if path in known}
    for unknown, values in zip(problem.unknowns[count:], points[:, count:].T, strict=True):
        if unknown.key in known and concerns(problem, unknown, segment):
            found[unknown.key] = unknown.scale * values
    return found


def adapt_steps(problem: Problem, x: Vector, tolerance: float) -> Problem:
    """The same problem with as many steps as its machine at a point takes."""
    every = []
    for number, one in enumerate(problem.experiments):
        numbers = columns_at(problem, x[np.newaxis], number)
        steps = automatic_steps(one, {path: row.item() for path, row in numbers.items()}, tolerance)
        every.append(with_experiment_steps(one, steps))
    return problem._replace(experiments=every)


def runs_at(problem: Problem, points: Vector, segment: int) -> Vector:
    """What a segment's machine shows at points of shape (runs, unknowns), neither late nor offset.

    The result has shape (samples, signals, runs), the signals those of MachineOutputs.
    """
    one, count = problem.experiments[segment], len(problem.space.ranges)
    offsets = {
        unknown.key: unknown.scale * points[:, i]
        for i, unknown in enumerate(problem.unknowns[count:], count)
        if unknown.kind == "offset" and unknown.where == one.segment.log
    }
    late = points[:, delay_of(problem, one.segment.log)]
    return predict_traces(one, columns_at(problem, points, segment), problem.threads, offsets, late)


def usual_values(own: Mapping[str, float], space: SearchSpace, unknowns: Sequence[UnknownNumber]) -> Vector:
    """The scenario's own values, a start as the log shows it, and else 0; each moved into its range."""
    found = []
    for one in unknowns:
        if one.kind in ("parameter", "uncertain"):
            found.append(share_of_range(space.ranges[one.key], own[one.key]))
        else:
            usual = 0.5 * (one.low + one.high) if one.kind == "start" else 0.0
            found.append(min(max(usual, one.low), one.high))
    return np.array(found)


def share_of_range(ends: tuple[float, float], value: float) -> float:
    """Where a value lies in its range, from 0 to 1, as in a :class:`~hydroservo.runs.tuning.SearchSpace`."""
    low, high = ends
    inside = min(max(value, low), high)
    if low * high > 0.0:
        return float(np.log(inside / low) / np.log(high / low))
    return (inside - low) / (high - low)


def lie_at_ends(problem: Problem, x: Vector) -> NDArray[np.bool_]:
    """Which unknowns lie at an end of their range, shape (unknowns,)."""
    low, high = problem.bounds
    near = END * (high - low)
    found: NDArray[np.bool_] = (x <= low + near) | (x >= high - near)
    return found
