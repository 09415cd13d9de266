"""The best gains of a loop, by a search that treats every law alike."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.wiring import wired
from hydroservo.core.block import value_at
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.validation import whole_number
from hydroservo.runs.arguments import checked_loops
from hydroservo.runs.objective import (
    OUTSIDE,
    SAFE,
    Aim,
    CandidateOutcome,
    candidate_outcome,
    check_ranges,
    checked_aim,
    checked_whole,
    geometric_mean,
    mean_of_cost,
    outcomes_at,
    search_costs,
    with_fixed_steps,
)
from hydroservo.runs.run import with_metrics
from hydroservo.runs.tuned import TriedValues, Tuned

Numbers = NDArray[np.float64]

CANDIDATES = 64  # of a generation: whole groups of lanes
DIGITS = 5  # of a rounded point; a rig's gains have no more


class SearchSpace(NamedTuple):
    """Ranges as a unit cube."""

    ranges: Mapping[str, tuple[float, float]]

    def values(self, units: Numbers) -> dict[str, Numbers]:
        """Parameters by path for points of shape (candidates, paths)."""
        found = {}
        for (path, (low, high)), unit in zip(self.ranges.items(), units.T, strict=True):
            between = low * (high / low) ** unit if low * high > 0.0 else low + (high - low) * unit
            found[path] = np.clip(between, low, high)
        return found

    def units(self, values: Numbers) -> Numbers:
        """The points of the cube that have some parameters, both of shape (candidates, paths)."""
        found = np.empty_like(values)
        for k, (low, high) in enumerate(self.ranges.values()):
            own = values[:, k]
            found[:, k] = (
                np.log(own / low) / np.log(high / low) if low * high > 0.0 else (own - low) / (high - low)
            )
        return np.clip(found, 0.0, 1.0)

    def rounded(self, unit: Numbers) -> dict[str, float]:
        """Parameters by path for one point of shape (paths,), with few digits."""
        found = {}
        for path, (value,) in self.values(unit[np.newaxis]).items():
            low, high = self.ranges[path]
            found[path] = min(max(float(f"{value:.{DIGITS}g}"), low), high)
        return found


def latin_hypercube(count: int, dimensions: int, seed: int) -> Numbers:
    """Points spread over the unit cube, shape (count, dimensions): those of scipy's LatinHypercube."""
    (rng,) = np.random.default_rng(seed).spawn(1)
    inside = rng.uniform(size=(count, dimensions))
    cells = rng.permuted(np.tile(np.arange(1, count + 1), (dimensions, 1)), axis=1)
    return np.asarray((cells.T - inside) / count)


def find_minimum(cost: Callable[[Numbers], Any], dimensions: int, generations: int, seed: int) -> Numbers:
    """The point of the unit cube at which a function of points of shape (dimensions, points) is smallest."""
    from scipy.optimize import differential_evolution

    found = differential_evolution(
        cost,
        [(0.0, 1.0)] * dimensions,
        init=latin_hypercube(CANDIDATES, dimensions, seed),
        maxiter=generations - 1,
        tol=0.0,
        atol=-1.0,  # never ends early: every law gets as many candidates
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=np.random.default_rng([seed, 1]),
    )
    return np.asarray(found.x)


Columns = Mapping[str, Numbers]
SearchProgress = Callable[[float, float], None]  # the fraction done, and the best geometric mean so far

CLOSEST = 30  # candidates that get a closer look, evenly in the logarithm of their rank, until one keeps it
SHOWN = 3  # problems of the nearest candidate
ROUNDS = 4  # in which candidates on the front are held against the bounds


class SearchGuard(Protocol):
    """Bounds that a search keeps, besides making a metric small."""

    def violations(self, candidates: Columns) -> Numbers:
        """How far each candidate is beyond the bounds, below 200; 0 within them."""
        ...

    def objections(self, parameters: Mapping[str, float]) -> Sequence[str]:
        """What is beyond the bounds with some values, by a closer look than ``violations`` takes."""
        ...


def search_gains(
    aim: Aim,
    ranges: Mapping[str, tuple[float, float]],
    candidates: int,
    seed: int,
    threads: int | None,
    progress: SearchProgress | None,
    guard: SearchGuard | None = None,
    guess: Mapping[str, float] | None = None,
    interrupted: Callable[[], None] = lambda: None,
) -> Tuned:
    """Search the parameters of loops that make a metric smallest.

    Differential evolution (best/1/bin, 64 candidates a generation) in the logarithm of each parameter whose
    range does not hold 0, in the parameter itself otherwise. The same seed gives the same result on any
    number of threads. A run that diverges is worse than any that does not, and a candidate beyond the guard's
    bounds is worse than any within. An interrupt ends the search with the best so far. Automatic substeps are
    those of the loops' own values, and found anew for the best.

    Args:
        aim: what is to be small.
        ranges: the lowest and highest value of each parameter, by its path, in SI units.
        candidates: how many sets of parameters are tried; rounded up to a multiple of 64.
        seed: of the search.
        threads: how many to use; all cores if None.
        progress: called after each generation.
        guard: the bounds to keep; None for none.
        guess: values to compare with, in SI units by path, of parameters that are searched.
        interrupted: called when an interrupt has ended the search.

    Raises:
        ParameterError: an unknown path, a metric that a loop does not have, a range that is none or leaves
            the parameter's own, a number out of its range, no candidate makes a valid controller, or the
            metric is 0 with all of them.
        HydroservoError: with every candidate some run diverged, or none keeps the bounds.
        KeyboardInterrupt: before there was anything to return.

    Source: Storn, Price, Journal of Global Optimization 11, 1997, doi:10.1023/A:1008202821328.
    Fails to promise the best there is: another seed may find a better one.
    """
    aim = ready_aim(aim)
    check_ranges(aim.loops, ranges)
    candidates, seed = whole_number("candidates", candidates, 1, 10**7), checked_whole("seed", seed)
    own = [{path: value_at(loop, path) for path in ranges} for loop in aim.loops]
    tables, before = outcomes_at(aim, own, threads)
    generations = math.ceil(candidates / CANDIDATES)
    search = GainSearch(
        with_fixed_steps(aim, tables), SearchSpace(ranges), generations, threads, progress, guard
    )
    stopped = False
    try:
        find_minimum(search.generation, len(ranges), generations, seed)
    except KeyboardInterrupt:
        if not search.within().any():
            raise
        stopped = True
        interrupted()
    point, parameters = search.best()
    found = tuned_values(aim, own[0], before, parameters, threads)
    if found.best.error == math.inf:
        raise HydroservoError("nothing found: with the best values some run diverged; try other ranges")
    return found._replace(
        runs=search.done * CANDIDATES * aim.seeds * len(aim.loops),
        edges=[path for path, unit in zip(ranges, point, strict=True) if not 0.01 < unit < 0.99],
        own=found.own._replace(within=guard is None or not guard.objections({})),
        guess=search.trial(own[0] | dict(guess)) if guess else None,
        front=search.front(),
        interrupted=stopped,
    )


def ready_aim(aim: Aim) -> Aim:
    """An aim with its loops complete, checked."""
    loops = [with_metrics(loop, aim.metrics) for loop in checked_loops(aim.loops)]
    return checked_aim(aim._replace(loops=[wired(loop) for loop in loops]))


def guessed_gains(
    aim: Aim, guess: Mapping[str, float], threads: int | None, guard: SearchGuard | None = None
) -> Tuned:
    """What a first guess of gains does to loops, without a search; ``search_gains`` has the arguments."""
    aim = ready_aim(aim)
    own = [{path: value_at(loop, path) for path in guess} for loop in aim.loops]
    _, before = outcomes_at(aim, own, threads)
    found = tuned_values(aim, own[0], before, guess, threads)
    pairs = {path: np.array([own[0][path], value]) for path, value in guess.items()}
    kept, keeps = (guard.violations(pairs) == 0.0).tolist() if guard else (True, True)
    best = found.best._replace(within=keeps)
    return found._replace(own=found.own._replace(within=kept), best=best, guess=best)


def tuned_values(
    aim: Aim,
    own: Mapping[str, float],
    before: Sequence[CandidateOutcome],
    parameters: Mapping[str, float],
    threads: int | None,
) -> Tuned:
    """What some values do to loops, beside the first loop's own and what all have with theirs."""
    tables, after = outcomes_at(aim, [parameters] * len(aim.loops), threads)
    best = tried_values(aim, parameters, after, within=True)
    return Tuned(
        parameters,
        before=errors_of(before),
        after=errors_of(after),
        cost=best.error,
        runs=0,
        edges=[],
        tables=tables,
        names=[f"loop {i}" for i in range(1, len(aim.loops) + 1)],
        metric=aim.metric,
        own=tried_values(aim, own, before, within=True),
        best=best,
    )


class CandidateTable(NamedTuple):
    """What is known of some candidates, each array of shape (candidates,) but for the points."""

    points: Numbers  # in the unit cube, shape (candidates, parameters)
    cost: Numbers  # of each
    error: Numbers  # weighted geometric mean of the metric
    activity: Numbers  # likewise of the command's total variation
    state: NDArray[np.int8]  # 1 within the bounds, 0 beyond them, -1 not known


class GainSearch:
    """One search, generation by generation."""

    def __init__(
        self,
        aim: Aim,
        space: SearchSpace,
        generations: int,
        threads: int | None,
        progress: SearchProgress | None,
        guard: SearchGuard | None,
    ) -> None:
        self.aim, self.space, self.generations = aim, space, generations
        self.threads, self.progress, self.guard = threads, progress, guard
        self.done, self.lowest, self.worst = 0, math.inf, 0.0
        self.parents = np.full(CANDIDATES, math.inf)
        self.trials: list[CandidateTable] = []

    def generation(self, units: Numbers) -> Numbers:
        """The cost of a generation's points, shape (parameters, candidates).

        Bounds are looked at where a candidate is better than the one whose place it would take.
        """
        values = self.space.values(units.T)
        outcomes = [candidate_outcome(self.aim, i, values, self.threads) for i in range(len(self.aim.loops))]
        cost = search_costs(self.aim, outcomes)
        state = np.full(cost.size, -1 if self.guard else 1, dtype=np.int8)
        if self.guard:
            due = np.flatnonzero((cost < OUTSIDE) & (cost <= self.parents))
            beyond = self.guard.violations({path: some[due] for path, some in values.items()})
            cost[due] = np.where(beyond > 0.0, OUTSIDE + beyond, cost[due])
            state[due] = beyond == 0.0
        state[cost >= OUTSIDE] = 0
        error = geometric_means(self.aim, [one.error for one in outcomes])
        activity = geometric_means(self.aim, [one.activity for one in outcomes])
        self.trials.append(CandidateTable(units.T.copy(), cost, error, activity, state))
        self.follow(cost)
        self.done, self.lowest = self.done + 1, min(self.lowest, cost[state == 1].min(initial=math.inf))
        self.worst = max(self.worst, *(one.error.max() for one in outcomes))
        if self.progress is not None:
            self.progress(self.done / self.generations, mean_of_cost(self.lowest))
        return cost

    def follow(self, cost: Numbers) -> None:
        """Keep the costs of the population as the optimiser does, its best in the first place."""
        self.parents = np.where(cost <= self.parents, cost, self.parents)
        least = int(self.parents.argmin())
        self.parents[[0, least]] = self.parents[[least, 0]]

    def every(self) -> CandidateTable:
        """All candidates so far."""
        return CandidateTable(*(np.concatenate(one) for one in zip(*self.trials, strict=True)))

    def within(self) -> NDArray[np.bool_]:
        """Which candidates are known to keep the bounds."""
        return self.every().state == 1 if self.trials else np.zeros(0, dtype=bool)

    def best(self) -> tuple[Numbers, dict[str, float]]:
        """The best point and its parameters, which keep the bounds at a closer look too."""
        if self.worst == 0.0:
            problem = (
                f"is 0 with each of {self.done * CANDIDATES:,} candidates, which says nothing; use another"
            )
            raise ParameterError("metric", self.aim.metric, problem)
        every, within = self.every(), self.within()
        order = np.argsort(np.where(within, every.cost, math.inf), kind="stable")
        count = int(within.sum())  # the first ones lie together at the bounds
        ranks = np.unique(np.geomspace(1.0, max(count, 1), CLOSEST).astype(np.int64)) - 1
        for i in order[ranks[:count]]:
            parameters = self.space.rounded(every.points[i])
            if self.guard is None or not self.guard.objections(parameters):
                return every.points[i], parameters
        raise HydroservoError(self.lost())

    def lost(self) -> str:
        """Why nothing was found."""
        every, count = self.every(), f"{self.done * CANDIDATES:,} candidates"
        least = int(every.cost.argmin())
        if self.guard is None or every.error[least] >= SAFE:
            nearest = self.space.rounded(every.points[least])
            outcomes_at(self.aim, [nearest] * len(self.aim.loops), self.threads)  # which may say why
            return f"nothing found: with each of {count} some run diverged; try other ranges"
        nearest = self.space.rounded(every.points[least])
        values = ", ".join(f"{path} = {value:g}" for path, value in nearest.items())
        problems = self.guard.objections(nearest)
        more = f"; and {len(problems) - SHOWN} more" if len(problems) > SHOWN else ""
        reasons = "; ".join(problems[:SHOWN]) or "they are beyond them before they are rounded"
        closely = " at a closer look" if self.within().any() else ""
        return (
            f"nothing found: none of {count} keeps the bounds{closely}. Nearest is {values}: {reasons}{more}"
        )

    def keeps(self, parameters: Mapping[str, float]) -> bool:
        """Whether some values keep the bounds."""
        if self.guard is None:
            return True
        return not self.guard.violations({path: np.array([one]) for path, one in parameters.items()}).any()

    def trial(self, parameters: Mapping[str, float]) -> TriedValues | None:
        """Some values, the same for all loops; None where they allow no controller."""
        try:
            _, outcomes = outcomes_at(self.aim, [parameters] * len(self.aim.loops), self.threads)
        except ParameterError:
            return None
        return tried_values(self.aim, parameters, outcomes, within=self.keeps(parameters))

    def front(self) -> list[TriedValues]:
        """The candidates within bounds that no other is better than in error and activity, calmest first."""
        points, _, error, activity, state = self.every()
        lost = ~(np.isfinite(activity) & (error < SAFE))
        for _ in range(ROUNDS):
            best = undominated_points(np.where(lost | (state == 0), math.inf, error), activity)
            open_ = best[state[best] == -1]
            if not open_.size or self.guard is None:
                break
            state[open_] = self.guard.violations(self.space.values(points[open_])) == 0.0
        return [
            TriedValues(self.space.rounded(points[i]), float(error[i]), float(activity[i]), within=True)
            for i in best[state[best] == 1]
        ]


def undominated_points(error: Numbers, activity: Numbers) -> NDArray[np.intp]:
    """The points with a smaller error than any calmer one, calmest first."""
    order = np.lexsort((error, activity))
    least = np.minimum.accumulate(np.append(math.inf, error[order]))
    return order[error[order] < least[:-1]]


def geometric_means(aim: Aim, each: Sequence[Numbers]) -> Numbers:
    """The weighted geometric mean over the loops, for each candidate."""
    return np.array([geometric_mean(aim.weights, one) for one in np.transpose(each)])


def tried_values(
    aim: Aim, parameters: Mapping[str, float], outcomes: Sequence[CandidateOutcome], *, within: bool
) -> TriedValues:
    activity = geometric_mean(aim.weights, [one.activity.item() for one in outcomes])
    return TriedValues(parameters, geometric_mean(aim.weights, errors_of(outcomes)), activity, within)


def errors_of(outcomes: Sequence[CandidateOutcome]) -> list[float]:
    """The metric of each loop with one candidate; inf where a run diverged."""
    return [one.error.item() if one.error.item() < SAFE else math.inf for one in outcomes]
