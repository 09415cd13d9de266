"""Commands that are tried for the next log: how large each may be, and what a log of it would tell."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import leaves
from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import number
from hydroservo.core.hooks import line_pressures
from hydroservo.identification.experiment import Experiment, experiment, predict_traces
from hydroservo.identification.log import COMMAND, OUTPUTS
from hydroservo.identification.prediction import prediction_problem
from hydroservo.identification.problem import PLACES, are_possible, unknowns_of, usual_values
from hydroservo.identification.result import FittedProblem, Identified
from hydroservo.identification.search import misfit_at
from hydroservo.identification.segments import Segment
from hydroservo.limits.command import command_limits
from hydroservo.runs.tuning import SearchSpace

TONES = 12
EACH = 8  # candidates of each kind
HIGHEST = 100.0  # Hz
SHARE = 0.1  # of the sampling frequency, which no tone exceeds
WIDEST = 4.0  # octaves above the lowest frequency that a band reaches at least, where it may

Samples = NDArray[np.float64]
MARGIN = 0.02  # of a stroke, at both its ends
ABOVE = 1.5  # times the supply's pressure, that a chamber's may be

SignalBounds = Mapping[str, tuple[float, float]]  # by signal, in SI units
DRAWS = 24  # machines that the logs allow, with which a command must keep its bounds
SIZES = 10  # that a candidate may have, tried in turn
FIRST = 0.005  # of what a command may be, to see how far it moves the machine
SECANTS = 4
SMALLER = (0.1, 0.75)  # times, between which the next is

Matrix = NDArray[np.float64]


class Candidate(NamedTuple):
    """A command before it has a size."""

    name: str  # what it is, for people
    values: Samples  # at each sample, largest size 1, mean 0


def candidates(samples: int, period: float, seed: int) -> list[Candidate]:
    """Commands of so many samples, one every ``period`` [s], as many of each kind.

    Source: Pintelon, Schoukens, System Identification, 2012, ch. 5 (multisines and chirps); Ljung, System
    Identification, 1999, sec. 13.3 (steps at random).
    Fails to hold the best command there is.
    """
    rng = np.random.default_rng(seed)
    time = period * np.arange(samples)
    kinds: tuple[Callable[..., Candidate], ...] = (multisine, chirp, random_steps)
    return [kind(time, rng) for _ in range(EACH) for kind in kinds]


def multisine(time: Samples, rng: np.random.Generator) -> Candidate:
    """Tones of one size and random phase, evenly over octaves."""
    low, high = frequency_band(time, rng)
    tones = np.geomspace(low, high, TONES)
    phases = rng.uniform(0.0, 2.0 * np.pi, TONES)
    name = f"multisine of {TONES} tones from {number(low)} to {number(high)} Hz"
    return even_candidate(name, np.sin(2.0 * np.pi * np.outer(time, tones) + phases).sum(axis=1))


def chirp(time: Samples, rng: np.random.Generator) -> Candidate:
    """A tone whose frequency grows by as many octaves each second."""
    low, high = frequency_band(time, rng)
    growth = np.log(high / low) / time[-1]
    angle = 2.0 * np.pi * low * np.expm1(growth * time) / growth
    return even_candidate(f"chirp from {number(low)} to {number(high)} Hz", np.sin(angle))


def random_steps(time: Samples, rng: np.random.Generator) -> Candidate:
    """Levels at random, each held for one to three times as long as the shortest."""
    low, high = frequency_band(time, rng)
    shortest = 0.25 / np.sqrt(low * high)
    jumps = np.cumsum(rng.uniform(1.0, 3.0, int(time[-1] / shortest) + 2)) * shortest
    levels = rng.uniform(-1.0, 1.0, jumps.size + 1)
    name = f"steps at random, {number(shortest)} to {number(3.0 * shortest)} s long"
    return even_candidate(name, levels[np.searchsorted(jumps, time, side="right")])


def frequency_band(time: Samples, rng: np.random.Generator) -> tuple[float, float]:
    """The lowest and the highest frequency of a command [Hz]."""
    least = 2.0 / time[-1]
    most = max(min(HIGHEST, SHARE * (time.size - 1) / time[-1]), 2.0 * least)
    low = float(np.exp(rng.uniform(np.log(least), np.log(np.sqrt(least * most)))))
    return low, float(np.exp(rng.uniform(np.log(min(WIDEST * low, most)), np.log(most))))


def even_candidate(name: str, values: Samples) -> Candidate:
    """A command of mean 0 and largest size 1."""
    even = values - values.mean()
    return Candidate(name, even / max(float(np.abs(even).max()), 1e-300))


def rolled_candidate(candidate: Candidate, share: float) -> Candidate:
    """The same command begun elsewhere in it, so that what it moves has room.

    What a command moves lies about where its sum does: it begins where that has so large a share of its
    travel below it.
    """
    travel = np.cumsum(candidate.values)
    least, most = float(travel.min()), float(travel.max())
    first = int(np.abs(travel - (least + min(max(share, 0.0), 1.0) * (most - least))).argmin())
    return candidate._replace(values=np.roll(candidate.values, -first - 1))


def bounds_of(loop: Loop, given: SignalBounds) -> dict[str, tuple[float, float]]:
    """Between what each signal must stay, in SI units: what is given, and else what the machine allows.

    A command has the limits of its converter, its law or its valve; a position the stroke less 2 % at both
    ends; a chamber's pressure 0 (gauge) and one and a half times the supply's.
    """
    allowed = (COMMAND, *OUTPUTS)
    for name, (low, high) in given.items():
        if name not in allowed:
            raise ParameterError("limits", name, f"is not a signal; they are {', '.join(allowed)}")
        if not low < high:
            raise ParameterError("limits", f"{name}: {low:g}..{high:g}", "must have its lower end first")
    own: dict[str, tuple[float, float]] = {}
    if COMMAND not in given:
        most = command_limits(loop).limit
        own[COMMAND] = -most, most
    stroke = getattr(loop.plant, "stroke", math.inf)
    if math.isfinite(stroke):
        own["position"] = MARGIN * stroke, (1.0 - MARGIN) * stroke
    supply = line_pressures(loop).supply
    own["pressure_a"] = own["pressure_b"] = 0.0, ABOVE * supply
    return {**own, **given}


def room_in_bounds(shown: NDArray[np.float64], bounds: SignalBounds) -> float:
    """How wide bounds are at least, over what the signals of all runs sweep; 0 if a run is lost."""
    if not np.isfinite(shown).all():
        return 0.0
    swept = {name: float(np.ptp(shown[:, PLACES[name]])) for name in bounds if name in PLACES}
    wide = (
        (bounds[name][1] - bounds[name][0]) / sweep if sweep > 0.0 else math.inf
        for name, sweep in swept.items()
    )
    return min(wide, default=math.inf)


def keeps_bounds(shown: NDArray[np.float64], bounds: SignalBounds) -> bool:
    """Whether all runs stay within bounds."""
    rows = ((shown[:, PLACES[name]], ends) for name, ends in bounds.items() if name in PLACES)
    return bool(
        np.isfinite(shown).all() and all(((low <= row) & (row <= high)).all() for row, (low, high) in rows)
    )


class SteadyCommand(NamedTuple):
    """A command under which a machine does not drift, and how far a larger one would move it."""

    command: float  # [V]
    slope: float  # of the drift over the whole command, by it [m/V]; 0 if nothing moves

    def corrected(self, mean: float, moved: float, bounds: SignalBounds) -> float:
        """The mean command without a drift, inside the limits of a command."""
        low, high = bounds[COMMAND]
        if self.slope == 0.0 or not np.isfinite(moved):
            return mean
        return min(max(mean - moved / self.slope, low), high)


class Trial(NamedTuple):
    """A command and what it would tell."""

    name: str  # of its kind
    command: Matrix  # at each sample [V]
    shown: Matrix  # of the machine found, shape (samples, signals)
    covariance: Matrix  # of the parameters with a log of it too, in units of the search


def openness(covariance: Matrix, own: Sequence[int]) -> float:
    """The sum of the logarithms of some parameters' variances."""
    return float(np.log(np.diag(covariance)[list(own)]).sum())


def draw_machines(fit: FittedProblem, seed: int) -> Matrix:
    """The unknowns found, then others that the logs allow, shape (machines, unknowns)."""
    rng = np.random.default_rng([seed, 1])
    count = len(fit.problem.space.ranges)
    points = np.repeat(fit.best.x[np.newaxis], 1 + DRAWS, axis=0)
    own = fit.sure.covariance[:count, :count]
    moved = rng.multivariate_normal(fit.best.x[:count], own, DRAWS, method="eigh")
    points[1:, :count] = np.clip(moved, 0.0, 1.0)
    return points[are_possible(fit.problem, points)]


def trial_of(
    found: Identified,
    candidate: Candidate,
    like: Segment,
    bounds: SignalBounds,
    machines: Matrix,
    held: SteadyCommand,
) -> Trial | None:
    """A candidate as large as the bounds allow, and what it would tell; None if no size keeps them.

    It lies about the command under which the machine found ends where it began, so that it does not drift.
    """
    low, high = bounds[COMMAND]
    values = rolled_candidate(candidate, room_below(found.fitted, bounds)).values
    size, mean = 1.0, held.command
    for _ in range(SIZES):
        command = np.clip(mean + min(high - mean, mean - low) * size * values, low, high)
        shown = traces_under(found.fitted, command, like.period, machines)
        if keeps_bounds(shown, bounds):
            nominal = shown[:, :, 0]
            return Trial(candidate.name, command, nominal, covariance_with(found, command, nominal, like))
        mean = held.corrected(mean, piston_drift(shown), bounds)
        size *= min(max(SMALLER[1] * room_in_bounds(shown, bounds), SMALLER[0]), SMALLER[1])
    return None


def steady_command(
    fit: FittedProblem, samples: int, period: float, bounds: SignalBounds, machines: Matrix
) -> SteadyCommand:
    """The command under which the machine found does not drift, by secants."""
    low, high = bounds[COMMAND]
    command, slope = 0.5 * (low + high), 0.0
    nudged, moved = command + FIRST * (high - low), 0.0
    before = piston_drift(traces_under(fit, np.full(samples, command), period, machines[:1]))
    for _ in range(SECANTS):
        moved = piston_drift(traces_under(fit, np.full(samples, nudged), period, machines[:1]))
        if nudged == command or not np.isfinite(moved) or moved == before:
            break
        slope = (moved - before) / (nudged - command)
        command, before = nudged, moved
        nudged = min(max(command - moved / slope, low), high)
    return SteadyCommand(command, slope)


def traces_under(fit: FittedProblem, command: Matrix, period: float, machines: Matrix) -> Matrix:
    """What machines would show under a command, shape (samples, signals, machines)."""
    problem = fit.problem
    columns = problem.columns(problem.space.values(machines[:, : len(problem.space.ranges)]))
    one = trial_experiment(fit, Segment(0, 0.0, period, {COMMAND: command}, {}))
    return predict_traces(one, columns, problem.threads)


def piston_drift(shown: Matrix) -> float:
    """How far the first machine's piston ends from where it began [m]."""
    row = shown[:, PLACES["position"], 0]
    return float(row[-1] - row[0])


def room_below(fit: FittedProblem, bounds: SignalBounds) -> float:
    """The share of the way that lies below where the scenario's piston starts; a half if it has no ends."""
    start = dict(leaves(fit.assembly.loop.plant)).get("start_position")
    if "position" not in bounds or not isinstance(start, float):
        return 0.5
    low, high = bounds["position"]
    return (start - low) / (high - low)


def trial_experiment(fit: FittedProblem, segment: Segment) -> Experiment:
    """An experiment with a command that was never played, from where the scenario starts."""
    like = fit.problem.experiments[0]
    substeps = like.loop.simulation.substeps
    own = fit.problem.space.values(fit.best.x[np.newaxis, : len(fit.problem.space.ranges)])
    return experiment(fit.assembly.loop, segment, tuple(fit.problem.columns(own)), substeps)


def covariance_with(found: Identified, command: Matrix, shown: Matrix, like: Segment) -> Matrix:
    """The covariance of the parameters with a log of a command too, in units of the search.

    The log's own delay, start and offsets are unknown in it.
    """
    fit = found.fitted
    count = len(fit.problem.space.ranges)
    measured = {name: shown[:, PLACES[name]] for name in like.measured}
    segment = Segment(0, 0.0, like.period, {COMMAND: command}, measured)
    playing = trial_experiment(fit, segment)
    spread = {
        (0, name): max(float(np.std(row)), 1e-300 + fit.problem.spread[like.log, name] * 1e-6)
        for name, row in measured.items()
    }
    unknowns = unknowns_of(fit.problem.space, [playing], spread, fit.problem.delays, fit.problem.uncertain)
    x = np.array([*fit.best.x[:count], *usual_values({}, SearchSpace({}), unknowns[count:])])
    weights = {(0, name): fit.best.weights[like.log, name] for name in measured}
    problem = fit.problem._replace(experiments=[playing], unknowns=unknowns, spread=spread, usual=x)
    if found.horizon is not None:
        problem = prediction_problem(problem, x, found.horizon, weights)
        x = problem.usual
    slopes = misfit_at(problem, x, weights).slopes
    information: Matrix = slopes.T @ slopes / variance_inflation(found)
    information[count:, count:] += np.diag([one.prior for one in problem.unknowns[count:]])
    information[:count, :count] += np.linalg.inv(fit.sure.covariance[:count, :count])
    found_with: Matrix = np.asarray(np.linalg.inv(information), dtype=np.float64)
    return found_with[:count, :count]


def variance_inflation(found: Identified) -> float:
    """How many times as large variances are as white residuals would leave them, on the mean; at least 1.

    A log to come is taken to hold as few independent samples.
    """
    sure, problem = found.fitted.sure, found.fitted.problem
    white = np.diag(np.linalg.inv(sure.information + np.diag([one.prior for one in problem.unknowns])))
    ratios = np.diag(sure.covariance) / white
    sharp = [ratios[i] for i, one in enumerate(found.parameters.values()) if one.identifiable]
    return max(float(np.exp(np.mean(np.log(sharp)))), 1.0) if sharp else 1.0
