"""A command for the next log, that tells what the logs so far do not."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import leaves
from hydroservo.errors import HydroservoError
from hydroservo.identification.bounds import Bounds, bounds_of, kept, room
from hydroservo.identification.candidates import Candidate, candidates, rolled
from hydroservo.identification.experiment import Experiment, experiment, predicted
from hydroservo.identification.fitted import Fitted
from hydroservo.identification.misfit import misfit
from hydroservo.identification.one_step import predicting
from hydroservo.identification.problem import Problem, is_possible, unknowns_of
from hydroservo.identification.result import Identified
from hydroservo.identification.search import Report
from hydroservo.identification.segments import Segment
from hydroservo.identification.signals import COMMAND, OUTPUTS
from hydroservo.identification.uncertainty import NORMAL

__all__ = ["Promise", "Proposal", "propose"]

DRAWS = 24  # machines that the logs allow, with which a command must keep its bounds
SIZES = 10  # that a candidate may have, tried in turn
FIRST = 0.005  # of what a command may be, to see how far it moves the machine
SECANTS = 4
NEWS = 0.5  # by which logarithms of variances fall, of which less is none
SMALLER = (0.1, 0.75)  # times, between which the next is
LONGEST = 10.0  # s

Matrix = NDArray[np.float64]


class Promise(NamedTuple):
    """What a log of a proposed command would make of one interval.

    Attributes:
        low: lower end of the 95 % interval about the value found so far.
        high: the upper end.
        times: how many times as narrow it would be.
        unit: SI.
    """

    low: float
    high: float
    times: float
    unit: str


class Proposal(NamedTuple):
    """A command for the next log.

    Attributes:
        name: what it is, for people.
        time: instants of its samples [s].
        command: at each [V].
        promises: what would become of each parameter's interval, by path.
        asked: the parameters for which it was chosen.
        reached: the least and the most of each signal of the machine found under it, by name.
        bounds: between what the signals were to stay.
    """

    name: str
    time: Matrix
    command: Matrix
    promises: Mapping[str, Promise]
    asked: Sequence[str]
    reached: Mapping[str, tuple[float, float]]
    bounds: Bounds

    def csv(self) -> str:
        """A table of time and command, as a rig plays it and a ``Recorded`` demand takes it."""
        rows = zip(self.time.tolist(), self.command.tolist(), strict=True)
        return "time [s],command [V]\n" + "".join(f"{t:.9g},{u:.6g}\n" for t, u in rows)


class Held(NamedTuple):
    """A command under which a machine does not drift, and how far a larger one would move it.

    Attributes:
        command: [V].
        slope: of the drift over the whole command, by it [m/V]; 0 if nothing moves.
    """

    command: float
    slope: float

    def corrected(self, mean: float, moved: float, bounds: Bounds) -> float:
        """The mean command without a drift, inside the limits of a command."""
        low, high = bounds[COMMAND]
        if self.slope == 0.0 or not np.isfinite(moved):
            return mean
        return min(max(mean - moved / self.slope, low), high)


class Trial(NamedTuple):
    """A command and what it would tell.

    Attributes:
        name: of its kind.
        command: at each sample [V].
        shown: of the machine found, shape (samples, signals).
        covariance: of the parameters with a log of it too, in units of the search.
    """

    name: str
    command: Matrix
    shown: Matrix
    covariance: Matrix


def propose(
    found: Identified,
    *,
    limits: Bounds | None = None,
    seed: int = 0,
    progress: Report | None = None,
) -> Proposal:
    """The command that would narrow the intervals of what the logs do not tell most::

        least of sum over s of ln cov_ss(u),   cov(u)^-1 = cov_0^-1 + J(u)' J(u)

    over multisines, chirps and steps at random u, each as large as the limits allow, with the covariance
    cov_0 that the logs so far leave, the slopes J of weighted signals by the parameters once the new log's
    own delay, start and offsets are sought too, and s the parameters that the logs do not tell; all of them
    if they tell all, or no command tells more of those. It is as long as the longest stretch of the logs,
    10 s at most, and starts where the scenario does. Limits are kept with the machine found and with up to 24
    others that the logs allow.

    Args:
        found: by :func:`~hydroservo.identify`.
        limits: between what the command and what is measured must stay, by name, in SI units. Else the
            command has its own limits, a position the stroke less 2 % at both ends, and a chamber's pressure
            0 and one and a half times the supply's.
        seed: of the candidates.
        progress: called now and then with the fraction done.

    Raises:
        ParameterError: a limit is none, or nothing limits the command.
        HydroservoError: no candidate keeps the limits.

    Source: Goodwin, Payne, Dynamic System Identification, 1977, ch. 6 (inputs from information).
    Fails where the machine is far from the one found: slopes are taken there; and to tell what no command
    tells, as two factors of one product.
    """
    report = progress or (lambda _: None)
    fit = found.fitted
    bounds = bounds_of(fit.assembly.loop, limits or {})
    longest = max((one.segment for one in fit.problem.experiments), key=lambda one: one.samples)
    samples = min(longest.samples, round(LONGEST / longest.period) + 1)
    tried = candidates(samples, longest.period, seed)
    machines = drawn(fit, seed)
    held = held_still(fit, samples, longest.period, bounds, machines)
    trials = []
    for number, one in enumerate(tried):
        trials.append(trial_of(found, one, longest, bounds, machines, held))
        report((number + 1) / len(tried))
    kept_ones = [one for one in trials if one is not None]
    if not kept_ones:
        ends = ", ".join(f"{name} in {low:g}..{high:g}" for name, (low, high) in bounds.items())
        raise HydroservoError(f"no command tried stays within the limits: {ends}")
    asked = asked_of(found, kept_ones)
    best = min(kept_ones, key=lambda one: openness(one.covariance, asked))
    names = list(found.parameters)
    return proposal(found, best, longest.period, [names[i] for i in asked], bounds)


def asked_of(found: Identified, trials: Sequence[Trial]) -> list[int]:
    """The parameters that the logs do not tell; all where they tell all, or no trial tells more of these."""
    count = len(found.parameters)
    untold = [i for i, one in enumerate(found.parameters.values()) if not one.identifiable]
    now = found.fitted.sure.covariance[:count, :count]
    best = min((openness(one.covariance, untold) for one in trials), default=0.0)
    return untold if untold and openness(now, untold) - best > NEWS else list(range(count))


def openness(covariance: Matrix, own: Sequence[int]) -> float:
    """The sum of the logarithms of some parameters' variances."""
    return float(np.log(np.diag(covariance)[list(own)]).sum())


def drawn(fit: Fitted, seed: int) -> Matrix:
    """The unknowns found, then others that the logs allow, shape (machines, unknowns)."""
    rng = np.random.default_rng([seed, 1])
    count = len(fit.problem.space.ranges)
    points = np.repeat(fit.best.x[np.newaxis], 1 + DRAWS, axis=0)
    own = fit.sure.covariance[:count, :count]
    moved = rng.multivariate_normal(fit.best.x[:count], own, DRAWS, method="eigh")
    points[1:, :count] = np.clip(moved, 0.0, 1.0)
    return np.array([point for point in points if is_possible(fit.problem, point)])


def trial_of(
    found: Identified, candidate: Candidate, like: Segment, bounds: Bounds, machines: Matrix, held: Held
) -> Trial | None:
    """A candidate as large as the bounds allow, and what it would tell; None if no size keeps them.

    It lies about the command under which the machine found ends where it began, so that it does not drift.
    """
    low, high = bounds[COMMAND]
    values = rolled(candidate, room_below(found.fitted, bounds)).values
    size, mean = 1.0, held.command
    for _ in range(SIZES):
        command = np.clip(mean + min(high - mean, mean - low) * size * values, low, high)
        shown = shown_under(found.fitted, command, like.period, machines)
        if kept(shown, bounds):
            nominal = shown[:, :, 0]
            return Trial(candidate.name, command, nominal, told_with(found, command, nominal, like))
        mean = held.corrected(mean, drift(shown), bounds)
        size *= min(max(SMALLER[1] * room(shown, bounds), SMALLER[0]), SMALLER[1])
    return None


def held_still(fit: Fitted, samples: int, period: float, bounds: Bounds, machines: Matrix) -> Held:
    """The command under which the machine found does not drift, by secants."""
    low, high = bounds[COMMAND]
    command, slope = 0.5 * (low + high), 0.0
    nudged, moved = command + FIRST * (high - low), 0.0
    before = drift(shown_under(fit, np.full(samples, command), period, machines[:1]))
    for _ in range(SECANTS):
        moved = drift(shown_under(fit, np.full(samples, nudged), period, machines[:1]))
        if nudged == command or not np.isfinite(moved) or moved == before:
            break
        slope = (moved - before) / (nudged - command)
        command, before = nudged, moved
        nudged = min(max(command - moved / slope, low), high)
    return Held(command, slope)


def shown_under(fit: Fitted, command: Matrix, period: float, machines: Matrix) -> Matrix:
    """What machines would show under a command, shape (samples, signals, machines)."""
    problem = fit.problem
    columns = problem.columns(problem.space.values(machines[:, : len(problem.space.ranges)]))
    one = played(fit, Segment(0, 0.0, period, {COMMAND: command}, {}))
    return predicted(one, columns, problem.threads)


def drift(shown: Matrix) -> float:
    """How far the first machine's piston ends from where it began [m]."""
    row = shown[:, list(OUTPUTS).index("position"), 0]
    return float(row[-1] - row[0])


def room_below(fit: Fitted, bounds: Bounds) -> float:
    """The share of the way that lies below where the scenario's piston starts; a half if it has no ends."""
    start = dict(leaves(fit.assembly.loop.plant)).get("start_position")
    if "position" not in bounds or not isinstance(start, float):
        return 0.5
    low, high = bounds["position"]
    return (start - low) / (high - low)


def played(fit: Fitted, segment: Segment) -> Experiment:
    """An experiment with a command that was never played, from where the scenario starts."""
    like = fit.problem.experiments[0]
    substeps = like.loop.simulation.substeps
    paths = [path for path in like.varied if path in dict(fit.problem.columns(middle(fit.problem)))]
    return experiment(fit.assembly.loop, segment, paths, substeps)


def middle(problem: Problem) -> Mapping[str, Matrix]:
    """Parameters in the middle of their ranges."""
    return problem.space.values(np.full((1, len(problem.space.ranges)), 0.5))


def told_with(found: Identified, command: Matrix, shown: Matrix, like: Segment) -> Matrix:
    """The covariance of the parameters with a log of a command too, in units of the search.

    The log's own delay, start and offsets are unknown in it.
    """
    fit, names = found.fitted, list(OUTPUTS)
    count = len(fit.problem.space.ranges)
    measured = {name: shown[:, names.index(name)] for name in like.measured}
    segment = Segment(0, 0.0, like.period, {COMMAND: command}, measured)
    playing = played(fit, segment)
    spread = {
        (0, name): max(float(np.std(row)), 1e-300 + fit.problem.spread[like.log, name] * 1e-6)
        for name, row in measured.items()
    }
    unknowns = unknowns_of(fit.problem.space, [playing], spread)
    others = (0.5 * (one.low + one.high) if one.kind == "start" else 0.0 for one in unknowns[count:])
    x = np.array([*fit.best.x[:count], *others])
    weights = {(0, name): fit.best.weights[like.log, name] for name in measured}
    problem = fit.problem._replace(experiments=[playing], unknowns=unknowns, spread=spread, usual=x)
    if found.horizon is not None:
        problem = predicting(problem, x, found.horizon, weights)
    slopes = misfit(problem, x, weights).slopes
    information: Matrix = slopes.T @ slopes / inflation(found)
    information[count:, count:] += np.diag([one.prior for one in unknowns[count:]])
    information[:count, :count] += np.linalg.inv(fit.sure.covariance[:count, :count])
    found_with: Matrix = np.asarray(np.linalg.inv(information), dtype=np.float64)
    return found_with[:count, :count]


def inflation(found: Identified) -> float:
    """How many times as large variances are as white residuals would leave them, on the mean; at least 1.

    A log to come is taken to hold as few independent samples.
    """
    sure, problem = found.fitted.sure, found.fitted.problem
    white = np.diag(np.linalg.inv(sure.information + np.diag([one.prior for one in problem.unknowns])))
    ratios = np.diag(sure.covariance) / white
    told = [ratios[i] for i, one in enumerate(found.parameters.values()) if one.identifiable]
    return max(float(np.exp(np.mean(np.log(told)))), 1.0) if told else 1.0


def proposal(
    found: Identified, trial: Trial, period: float, asked: Sequence[str], bounds: Bounds
) -> Proposal:
    """The best of all trials as it is proposed."""
    space, count = found.fitted.problem.space, len(found.parameters)
    own = found.fitted.best.x[:count]
    after: Matrix = np.sqrt(np.diag(trial.covariance))
    low, high = (space.values((own + sign * NORMAL * after)[np.newaxis]) for sign in (-1.0, 1.0))
    before = found.fitted.sure.deviations[:count]
    promises = {
        path: Promise(float(low[path][0]), float(high[path][0]), float(before[i] / after[i]), one.unit)
        for i, (path, one) in enumerate(found.parameters.items())
    }
    reached = {
        name: (float(row.min()), float(row.max())) for name, row in zip(OUTPUTS, trial.shown.T, strict=True)
    }
    time: Matrix = period * np.arange(trial.command.size, dtype=np.float64)
    return Proposal(trial.name, time, trial.command, promises, asked, reached, bounds)
