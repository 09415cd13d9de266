"""Predictions from what was measured just before, in place of a simulation of the whole log."""

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import leaves
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.identification.experiment import Experiment, kernel_for
from hydroservo.identification.log import OUTPUTS
from hydroservo.identification.observer import CORRECTED, PUSH, LogObserver, fading_gain, memory_rows
from hydroservo.identification.problem import FAR, Problem, UnknownNumber, columns_at, delay_of
from hydroservo.identification.search import Report, Solution, Weights, first_weights, settle_weights

if TYPE_CHECKING:
    from hydroservo.engine.lanes import CompiledLanes

USUAL = 0.05  # s, in which predictions forget
NUDGE = 1e-4  # of a state's spread over a log, for its difference
DESIGNS = 2  # of observers, the second at what the first gave

Matrix = NDArray[np.float64]


class LinearMachine(NamedTuple):
    """The mean linear machine over a log, in units of its states' spreads."""

    transition: Matrix  # of the states and the unknown force over a sample, shape (n, n)
    seen: Matrix  # of all signals at it, shape (signals, n), in SI units
    spreads: Matrix  # of the states and the force, shape (n,), in SI units
    paths: Sequence[str]  # of the states that change, and of the force


def best_prediction(
    problem: Problem, simulated: Solution, horizon: float, report: Report
) -> tuple[Problem, Solution]:
    """The unknowns that make weighted errors of prediction smallest, from those that a simulation gave.

    A prediction forgets what was measured within the ``horizon`` [s]. The problem is then that of
    predictions.
    """
    best = simulated
    for number in range(DESIGNS):
        problem = prediction_problem(problem, best.x, horizon)
        best = best._replace(x=np.append(best.x, problem.usual[best.x.size :]))
        best = settle_weights(problem, best, partial(report_design, report, number))
    return problem, best


def report_design(report: Report, number: int, part: float) -> None:
    report((number + part) / DESIGNS)


def prediction_problem(
    problem: Problem, x: Matrix, horizon: float, weights: Weights | None = None
) -> Problem:
    """The same problem with predictions in place of simulations.

    An observer lets each simulated machine follow what was measured, and an unknown force on the rod with
    it::

        x_(k+1) = f(x_k, u_k; theta) + K (y_(k-1) - yhat_(k-1)(theta))

    with the prediction yhat, as late as y is, so that a residual tells of the last ``horizon`` alone. K is
    that of least squares which forget within the horizon, for the machine at ``x``, linearised along the log;
    it stays as it is while parameters are sought.

    Source: Ljung, System Identification, 1999, secs. 3.2 and 4.3 (predictions with an observer's gain).
    Fails to be free of bias where noise is large and the horizon is of a few samples, for the gain is not
    that which this noise asks for; and follows an unknown force no faster than the horizon.
    """
    weights = weights or first_weights(problem)
    found = [with_observer(problem, i, x, weights, horizon) for i in range(len(problem.experiments))]
    known = [one.key for one in problem.unknowns]
    begun = [] if PUSH in known else [force_at_start(one, i) for i, one in enumerate(found)]
    return problem._replace(
        experiments=found,
        unknowns=[*problem.unknowns, *begun],
        usual=np.append(problem.usual, np.zeros(len(begun))),
    )


def force_at_start(one: Experiment, number: int) -> UnknownNumber:
    """The force at the start of a segment by which the scenario's load is wrong.

    Were it not sought, the observer would take some horizons to find it, and all else would make up for that.
    """
    force = 1.0 if one.observer is None else one.observer.force
    return UnknownNumber(f"force at {one.segment.start:g} s", "start", number, PUSH, force, -FAR, FAR)


def with_observer(problem: Problem, number: int, x: Matrix, weights: Weights, horizon: float) -> Experiment:
    one = problem.experiments[number]
    segment = one.segment
    if horizon < 2.0 * segment.period:
        wanted = f"must be at least two samples, {2.0 * segment.period:g} s"
        raise ParameterError("horizon", horizon, wanted)
    varied = (*(path for path in one.varied if path != PUSH), PUSH)
    plain = one._replace(varied=varied, observer=None)
    machine = linear_machine(problem, plain, number, x, horizon)
    names = list(OUTPUTS)
    places = [names.index(name) for name in segment.measured]
    noise = np.array([1.0 / weights[segment.log, name] for name in segment.measured])
    forgetting = math.exp(segment.period / horizon)
    small = fading_gain(machine.transition, machine.seen[places], noise, forgetting)
    gain = np.zeros((len(machine.paths), len(names)))
    gain[:, places] = machine.spreads[:, np.newaxis] * small
    measured = np.full((segment.samples, len(names)), np.nan)
    for place, values in zip(places, segment.measured.values(), strict=True):
        measured[:, place] = values
    whole = round(x[delay_of(problem, segment.log)])
    force = float(machine.spreads[-1]) * horizon / segment.period
    return plain._replace(observer=LogObserver(measured, machine.paths, gain, whole, force))


def linear_machine(
    problem: Problem, one: Experiment, number: int, x: Matrix, horizon: float
) -> LinearMachine:
    """The mean of the machine's slopes over a log, by differences in lanes beside each other."""
    from hydroservo.engine.lanes import LANES, monitor_traces

    kernel, started = kernel_for(one, columns_at(problem, x[np.newaxis], number))
    samples, period = one.segment.samples, one.segment.period
    states = [path for path, _ in leaves(kernel.state) if path.startswith(CORRECTED)]
    run = StateFollower(kernel, states, np.zeros(len(states)))
    monitor_traces(kernel, started, samples, period, run.keep)
    own = np.std(run.states, axis=0)
    if not np.isfinite(own).all():
        raise HydroservoError("a run with these parameters diverges; try other ranges")
    paths = (*(path for path, spread in zip(states, own, strict=True) if spread > 0.0), PUSH)
    if len(paths) >= LANES:
        raise HydroservoError(f"{len(paths)} states are too many for an observer; simulate instead")
    spreads = np.array([*own[own > 0.0], 1.0])  # of the force, to begin with
    run = StateFollower(kernel, paths, NUDGE * spreads)
    shown = monitor_traces(kernel, started, samples, period, run.nudge)
    seen = (shown[1:, :, 1 : 1 + len(paths)] - shown[1:, :, :1]).mean(axis=0) / NUDGE
    transition = run.slopes / (samples - 1) / (NUDGE * spreads[:, np.newaxis])
    if not (np.isfinite(seen).all() and np.isfinite(transition).all()):
        raise HydroservoError("the observer diverges on this run; simulate instead")
    push = np.abs(transition[:-1, -1]).max() * horizon / period
    force = 1.0 / push if push > 0.0 else 1.0
    transition[:, -1] *= force
    transition[-1] /= force
    seen[:, -1] *= force
    return LinearMachine(transition, seen, np.array([*spreads[:-1], force]), paths)


class StateFollower:
    """States of lanes after each sample, and how those that are nudged before it come apart."""

    def __init__(self, kernel: "CompiledLanes", paths: Sequence[str], nudges: Matrix) -> None:
        self.layout, self.rows, self.nudges = kernel.layout, memory_rows(kernel, paths), nudges
        self.states: list[Matrix] = []
        self.slopes = np.zeros((len(paths), len(paths)))

    def keep(self, _: int, memory: Matrix) -> None:
        """Keep the first lane's states."""
        self.states.append(memory[self.rows, 0].copy())

    def nudge(self, k: int, memory: Matrix) -> None:
        """Take over how lanes have come apart, and put each beside the first again."""
        count, layout = len(self.rows), self.layout
        if k > 0:
            self.slopes += memory[self.rows, 1 : 1 + count] - memory[self.rows, :1]
        memory[layout.states : layout.sums] = memory[layout.states : layout.sums, :1]
        memory[self.rows] = memory[self.rows, :1]
        memory[self.rows, np.arange(1, 1 + count)] += self.nudges
