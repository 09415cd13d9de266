"""Effects that a scenario leaves out, as disturbances, and which of them look like what a model misses."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import Field, field_at, leaves, replace
from hydroservo.core.errors import HydroservoError
from hydroservo.core.formatting import MINUS, number, quantity
from hydroservo.core.roles import Load
from hydroservo.core.signals import Demand, Measurement
from hydroservo.identification.experiment import Experiment, predict_traces
from hydroservo.identification.log import COMMAND, SIGNALS
from hydroservo.identification.observer import shift_signals
from hydroservo.identification.problem import PLACES, Problem, columns_at, delay_of, lie_at_ends
from hydroservo.identification.search import Misfit, Solution
from hydroservo.limits.command import PlaybackState
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario.load import MachineBlocks

STILL = 0.01  # of the largest speed, below which friction changes sign smoothly
WIDTH = 0.02  # of the largest command, of a hysteresis and an overlap
AIR = 1e5  # Pa, about where air in the oil counts

Vector = NDArray[np.float64]
SMALL = 1e-3  # of the largest command or force, by which an effect is tried
CUT = 3.0  # deviations, to which residuals are cut
OWN = 1e-3  # share of an effect's square that what was sought must leave of it
LEAST = 0.01  # share of what is left, from which an effect is named
MOST = 5  # effects that are named
ALIKE = 0.9  # correlation with the first effect, from which on the log does not tell them apart

Key = tuple[str, str, bool]  # of an effect: its name, its unit, and whether it is above 0 alone
Changes = dict[Key, Vector]  # of residuals, per amount of an effect


class Direction(NamedTuple):
    """An effect as a signal that drives the machine beside what was recorded."""

    name: str  # of the effect
    unit: str  # of its amount; "" where that means nothing by itself
    values: Vector  # per amount of 1, shape (n,)
    positive: bool  # whether only an amount above 0 makes sense


class DisturbedPlayback(NamedTuple):
    """u_k = recorded command + amount times one of several directions."""

    commands: Annotated[NDArray[np.float64], Field("V", "command at each sample, shape (samples,)")]
    directions: Annotated[NDArray[np.float64], Field("", "shape (directions, samples)")]
    which: Annotated[float, Field("", "number of the direction")] = 0.0
    amount: Annotated[float, Field("", "how much of it")] = 0.0

    def init(self) -> PlaybackState:
        return PlaybackState(0.0, 0.0)

    def step(self, s: PlaybackState, y: Measurement, r: Demand, dt: float) -> PlaybackState:
        k = int(s.sample)
        u = float(self.commands[k]) + self.amount * float(self.directions[int(self.which), k])
        return PlaybackState(u, s.sample + 1.0)


class DisturbedLoad(NamedTuple):
    """F(t) = force of a load + amount times one of several directions, held from sample to sample."""

    load: Load
    directions: Annotated[NDArray[np.float64], Field("", "shape (directions, samples)")]
    period: Annotated[float, Field("s", "between samples")]
    which: Annotated[float, Field("", "number of the direction")] = 0.0
    amount: Annotated[float, Field("", "how much of it")] = 0.0

    def force(self, t: float) -> float:
        k = int(t / self.period)
        return self.load.force(t) + self.amount * float(self.directions[int(self.which), k])

    def next_jump(self, t: float) -> float:
        return self.load.next_jump(t)


def disturbed_experiment(
    one: Experiment, machine: Loop, forces: Sequence[Direction], commands: Sequence[Direction]
) -> Experiment:
    """The experiment of a machine that takes a direction of force or command."""
    segment = one.segment
    law = DisturbedPlayback(
        np.ascontiguousarray(segment.inputs[COMMAND]), np.array([own.values for own in commands])
    )
    padded = np.array([np.append(own.values, own.values[-1]) for own in forces])
    given = machine._replace(controller=law, load=DisturbedLoad(machine.load, padded, segment.period))
    varied = ("load.which", "load.amount", "controller.which", "controller.amount")
    return Experiment(segment, given, runnable_loop(given), {}, varied)


def force_directions(one: Experiment, shown: Mapping[str, Vector]) -> Iterator[Direction]:
    """Forces on the rod, positive against motion, per unit of their amount."""
    speed, position = shown["velocity"], shown["position"]
    time = one.segment.time - one.segment.start
    still = STILL * max(float(np.abs(speed).max()), 1e-9)
    yield Direction("dry friction", "N", np.tanh(speed / still), True)
    yield Direction("friction that differs by direction", "N", np.abs(np.tanh(speed / still)), False)
    yield Direction("viscous friction", "N s/m", speed, True)
    yield Direction("a constant force", "N", np.ones(speed.size), False)
    yield Direction("a force that drifts", "N/s", time - time.mean(), False)
    yield Direction("a spring", "N/m", position - position.mean(), False)


def command_directions(command: Vector, shown: Mapping[str, Vector], period: float) -> Iterator[Direction]:
    """Changes of the command as the valve would feel it, per unit of their amount."""
    largest = max(float(np.abs(command).max()), 1e-6)
    width = WIDTH * largest
    yield Direction("valve hysteresis", "V", (backlash(command, width) - command) / width, True)
    yield Direction("valve overlap", "V", -np.clip(command, -width, width) / width, True)
    yield Direction("a shift of the valve's null", "V", np.ones(command.size), False)
    yield Direction("a valve gain that differs by direction", "", np.abs(command), False)
    load = shown["hydraulic_force"]
    yield Direction("leakage", "", -load / max(float(np.abs(load).max()), 1.0), True)
    sides = [shown["pressure_a"], shown["pressure_b"]]
    rates = [np.gradient(side, period) / np.maximum(side + AIR, 0.1 * AIR) ** 2 for side in sides]
    air = rates[1] - rates[0]
    yield Direction("air in the oil", "", air / max(float(np.abs(air).max()), 1e-30), True)


def backlash(command: Vector, width: float) -> Vector:
    """A command through a backlash of a full width: the play operator."""
    played, at = np.empty(command.size), float(command[0])
    for k, value in enumerate(command.tolist()):
        at = min(max(at, value - 0.5 * width), value + 0.5 * width)
        played[k] = at
    return played


def largest_value(own: Direction) -> float:
    return max(float(np.abs(own.values).max()), 1e-300)


class LeftOutEffect(NamedTuple):
    """An effect that a scenario leaves out, and how much of what the model misses it would explain.

    Attributes:
        name: of the effect.
        amount: of it that fits best, in its unit; nan where it has none of its own.
        unit: SI.
        share: of the residuals' square that it explains, 0 to 1.
        alike: whether the logs do not tell it apart from the first one.
    """

    name: str
    amount: float
    unit: str
    share: float
    alike: bool

    def __str__(self) -> str:
        amount = "" if math.isnan(self.amount) else f" of {quantity(self.amount, self.unit)}"
        explained = f"explains {number(100.0 * self.share, 2)} % of what is left"
        return f"{self.name}{amount} ({explained})".replace(MINUS, "-")


def effects_left_out(problem: Problem, best: Solution, found: Misfit) -> list[LeftOutEffect]:
    """The effects that would explain most of the residuals, the largest share first.

    Each effect drives the machine a little beside what was recorded, as the motion found says it would: dry
    friction as a force against it, hysteresis as the recorded command through a backlash. What the machine
    then shows otherwise, less what the unknowns that were sought could do of it, is held against the
    residuals: a score test, in the direction of the effect. An unknown at an end of its range could do no
    more, and is an effect itself.

    Source: Rao, Mathematical Proceedings of the Cambridge Philosophical Society 44, 1948 (score tests).
    Fails for effects that change the motion much, which are not in proportion to their amount, and to name
    one that is not among those tried.
    """
    columns = beyond_ranges(problem, best, found)
    for i in range(len(problem.experiments)):
        for part in (driving_changes, number_changes, sensor_changes):
            with suppress(HydroservoError):
                for key, row in part(problem, best, found, i).items():
                    columns[key] = columns.get(key, 0.0) + row
    free = ~lie_at_ends(problem, best.x)
    slopes, prior = (
        found.slopes[:, free],
        np.diag([one.prior for one in problem.unknowns])[np.ix_(free, free)],
    )
    inverse = np.linalg.inv(slopes.T @ slopes + prior)

    def apart(row: Vector) -> Vector:
        rest: Vector = row - slopes @ (inverse @ (slopes.T @ row))
        return rest

    missed = apart(np.clip(found.residuals, -CUT, CUT))
    scores = []
    for (name, unit, positive), row in columns.items():
        own = apart(row)
        size = float(own @ own)
        if size <= OWN * float(row @ row):
            continue
        amount = float(own @ missed) / size
        share = amount**2 * size / float(missed @ missed)
        if share > LEAST and (amount > 0.0 or not positive):
            effect = LeftOutEffect(name, amount if unit else math.nan, unit, share, alike=False)
            scores.append((effect, own / math.sqrt(size)))
    scores.sort(key=lambda score: -score[0].share)
    return [
        effect._replace(alike=i > 0 and abs(float(scores[0][1] @ own)) > ALIKE)
        for i, (effect, own) in enumerate(scores[:MOST])
    ]


def beyond_ranges(problem: Problem, best: Solution, found: Misfit) -> Changes:
    """What unknowns at an end of their range would change beyond it."""
    rows = {}
    for i in np.flatnonzero(lie_at_ends(problem, best.x)):
        one = problem.unknowns[int(i)]
        outwards = 1.0 if best.x[i] > 0.5 * (one.low + one.high) else -1.0
        rows[f"{one.name} beyond its range", "", True] = -outwards * found.slopes[:, i]
    return rows


def driving_changes(problem: Problem, best: Solution, found: Misfit, number: int) -> Changes:
    """What effects that drive the machine of a segment would change."""
    one, machine = problem.experiments[number], loop_at(problem, best, number)
    shown = predict_traces(one, columns_at(problem, best.x[np.newaxis], number), problem.threads)[:, :, 0]
    signals = {name: np.nan_to_num(shown[:, place]) for name, place in PLACES.items()}
    command = one.segment.inputs[COMMAND]
    forces = list(force_directions(one, signals))
    commands = list(command_directions(command, signals, one.segment.period))
    force = SMALL * max(float(np.abs(signals["hydraulic_force"]).max()), 1.0)
    volts = SMALL * max(float(np.abs(command).max()), 1e-3)
    runs = [(float(k), force / largest_value(own), 0.0, 0.0) for k, own in enumerate(forces)]
    runs += [(0.0, 0.0, float(k), volts / largest_value(own)) for k, own in enumerate(commands)]
    playing = disturbed_experiment(one, machine, forces, commands)
    lanes = dict(zip(playing.varied, np.array([(0.0, 0.0, 0.0, 0.0), *runs]).T, strict=True))
    keys = [(own.name, own.unit, own.positive) for own in (*forces, *commands)]
    amounts = [run[1] + run[3] for run in runs]
    return changes_per_amount(
        problem, best, found, number, playing, lanes, dict(zip(keys, amounts, strict=True))
    )


def number_changes(problem: Problem, best: Solution, found: Misfit, number: int) -> Changes:
    """What other values of the machine's numbers that were not sought would change."""
    machine = loop_at(problem, best, number)
    sought = columns_at(problem, best.x[np.newaxis], number)
    given = {
        path: value
        for path, value in leaves(machine)
        if path.partition(".")[0] in MachineBlocks._fields
        and path not in sought
        and isinstance(value, float)
        and value not in (0.0, field_at(machine, path).auto)
        and math.isfinite(value)
    }
    segment = problem.experiments[number].segment
    playing = Experiment(segment, machine, runnable_loop(machine), {}, tuple(given))
    lanes = {path: np.full(1 + len(given), value) for path, value in given.items()}
    for k, (path, value) in enumerate(given.items(), 1):
        lanes[path][k] = value * (1.0 + SMALL)
    amounts = {(f"a wrong {path}", "", False): SMALL for path in given}
    return changes_per_amount(problem, best, found, number, playing, lanes, amounts)


def loop_at(problem: Problem, best: Solution, number: int) -> Loop:
    """The loop that plays a segment, with what was found."""
    numbers = columns_at(problem, best.x[np.newaxis], number)
    loop: Loop = replace(
        problem.experiments[number].given, {path: row.item() for path, row in numbers.items()}
    )
    return loop


def changes_per_amount(
    problem: Problem,
    best: Solution,
    found: Misfit,
    number: int,
    playing: Experiment,
    lanes: Mapping[str, Vector],
    amounts: Mapping[Key, float],
) -> Changes:
    """What runs show otherwise than the first of them, per amount of their effect.

    The first of the runs in ``lanes`` has no effect; ``amounts`` are those of the others.
    """
    traces = predict_traces(playing, lanes, problem.threads)
    late = float(best.x[delay_of(problem, playing.segment.log)])
    rows = {}
    for k, (key, amount) in enumerate(amounts.items(), 1):
        change = shift_signals(traces[:, :, k] - traces[:, :, 0], late) / amount
        rows[key] = weighted_change(problem, best, found, number, change)
    return rows


def sensor_changes(problem: Problem, best: Solution, found: Misfit, number: int) -> Changes:
    """What a drift and a wrong scale of each sensor would change.

    The scale is that of the signal simulated, for the measured one's noise is in the residuals, too.
    """
    segment = problem.experiments[number].segment
    time = segment.time - segment.start
    rows = {}
    for name in segment.measured:
        nothing = np.zeros((segment.samples, len(PLACES)))
        place = PLACES[name]
        drift, scale = nothing.copy(), nothing.copy()
        drift[:, place] = time - time.mean()
        noise = found.residuals[found.rows[number, name]] / best.weights[segment.log, name]
        scale[:, place] = np.nan_to_num(segment.measured[name] - noise)
        unit = f"{SIGNALS[name].unit}/s"
        rows[f"drift of {name}", unit, False] = weighted_change(problem, best, found, number, drift)
        rows[f"a wrong scale of {name}", "", False] = weighted_change(problem, best, found, number, scale)
    return rows


def weighted_change(problem: Problem, best: Solution, found: Misfit, number: int, change: Vector) -> Vector:
    """A change of all signals of a segment as residuals count it, shape (rows,)."""
    row = np.zeros(found.residuals.size)
    for (i, name), place in found.rows.items():
        if i == number:
            weight = best.weights[problem.experiments[i].segment.log, name]
            own = weight * np.nan_to_num(change[:, PLACES[name]])
            row[place] = np.where(found.there[place], own, 0.0)
    return row
