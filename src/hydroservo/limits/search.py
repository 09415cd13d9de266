"""The search for the best commands of a loop: what it knows, where it begins, and the runs that they make."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.controlled import Command
from hydroservo.control.loop import Loop
from hydroservo.control.monitors import TrackingError
from hydroservo.core.block import leaves, replace, values
from hydroservo.core.errors import ParameterError
from hydroservo.cosimulation import refuse_fmus
from hydroservo.limits.command import CommandLimits, Playback
from hydroservo.limits.problem import Course, Optimum, PeriodModel, ProblemScales, optimum, period_model
from hydroservo.machine.integrators.jumps import BEFORE
from hydroservo.runs.cautions import with_warning
from hydroservo.runs.run import RunProgress, runnable_loop, simulate
from hydroservo.runs.steady import state_sizes
from hydroservo.runs.trace import plan_of

if TYPE_CHECKING:
    import xarray as xr

JUMP = 0.05  # of a signal's whole range: a step of the integrator that changes it more is a jump

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]
Places = NDArray[np.intp]
COMMAND = "controller.u"
DEMAND = "reference.value"
SIGNAL = "controlled.value"
MOST_UNKNOWNS = 10**6  # states and commands, of some kilobytes each
CAUSAL = 0.5  # of the work, that is done after it
APART = 1e-3  # of the size of errors, by which a command that is played back may miss what its search says

TAIL = 0.1  # of a stretch between jumps: how much longer it is expected to last
LEAST_TAIL = 20  # samples
SamplesDone = Callable[[int], None]  # called with the samples that are done


class Foreknowledge(NamedTuple):
    """Demand and load at the steps of the integrator."""

    demand: Vector  # at the beginning of each step, shape (steps,)
    rate: Vector  # its rate there
    second_rate: Vector  # and that of its rate
    # on the rod at the beginning, middle and end of each [N], shape (3, steps); before a jump at its end
    force: Matrix
    step: float  # how long one takes [s]
    substeps: int  # how many there are in a sample period

    def table(self, first: int, last: int) -> Matrix:
        """What an interval knows, of samples first to last - 1: shape (4 substeps, samples)."""
        chosen, samples = slice(first * self.substeps, last * self.substeps), last - first
        forces = self.force[:, chosen].T.reshape(samples, -1)
        return np.hstack([forces, self.demand[chosen].reshape(samples, -1)]).T


def foreknowledge(loop: Loop, samples: int) -> Foreknowledge:
    """The demand and the load of a loop, over so many samples."""
    simulation = loop.simulation
    period, substeps = simulation.period, simulation.substeps
    h = period / substeps
    starts = [k * period + i * h for k in range(samples) for i in range(substeps)]
    demands = np.array([loop.reference.at(t) for t in starts])
    forces = np.array([forces_of(loop, t, h) for t in starts]).T
    value, rate, second_rate = demands.T
    return Foreknowledge(value, rate, second_rate, forces, h, substeps)


def forces_of(loop: Loop, t: float, h: float) -> tuple[float, float, float]:
    """The load [N] at the three instants at which RK4 asks for it in a step."""
    force, jump = loop.load.force, loop.load.next_jump(t)
    end = t + h if BEFORE * (t + h) > jump else min(t + h, BEFORE * jump)
    return force(t), force(t + 0.5 * h), force(end)


def jump_steps(known: Foreknowledge) -> tuple[Places, Places]:
    """The steps at whose beginning the demand, or its rate, jumps; and those at which the load does.

    A signal jumps where a step changes it by more than a twentieth of its whole range beyond what its rate
    says; a rate likewise, by that of its range from 0.
    """
    h, size = known.step, np.abs(known.rate).max()
    moved = np.diff(known.demand) - h * known.rate[:-1] - 0.5 * h * h * known.second_rate[:-1]
    turned = np.diff(known.rate) - h * known.second_rate[:-1]
    demand = (np.abs(moved) > JUMP * np.ptp(known.demand)) | (np.abs(turned) > JUMP * size)
    load = np.abs(known.force[0, 1:] - known.force[2, :-1]) > JUMP * np.ptp(known.force)
    return np.flatnonzero(demand) + 1, np.flatnonzero(load) + 1


def expected_course(known: Foreknowledge, step: int) -> Foreknowledge:
    """What is expected of demand and load where no jump is foreseen that comes at a step or after it.

    From the first such jump on the demand goes on at its rate, and the load stays as it is.
    """
    demand, force = known.demand.copy(), known.force.copy()
    of_demand, of_load = (found[found >= step] for found in jump_steps(known))
    if of_demand.size:
        last = of_demand[0] - 1
        after = np.arange(1, demand.size - last)
        demand[last + 1 :] = demand[last] + after * known.step * known.rate[last]
    if of_load.size:
        force[:, of_load[0] :] = force[2, of_load[0] - 1]
    return known._replace(demand=demand, force=force)


class Beginning(NamedTuple):
    """The course with which a search begins, and what its numbers are measured by."""

    course: Course
    scales: ProblemScales


def remembers_command(loop: Loop, limits: CommandLimits) -> bool:
    """Whether the command of the sample before is part of a state: it still acts, or limits the next one."""
    return limits.rated or hasattr(loop.hold, "delay")


def run_beginning(loop: Loop, limits: CommandLimits, run: "xr.Dataset") -> Beginning:
    """A run of the loop; where it diverged, rest."""
    if run["diverged"]:
        return rest_beginning(loop, limits, run)
    states = np.array([run[path].values for path, _ in leaves(loop.machine(loop.init()))])
    commands = run[COMMAND].values[:-1]
    scales = ProblemScales(
        np.array([largest_or_one(row) for row in states]), largest_or_one(commands), run_error(run)
    )
    return scaled_beginning(loop, limits, states, commands, scales)


def rest_beginning(loop: Loop, limits: CommandLimits, run: "xr.Dataset") -> Beginning:
    """A machine that stays as it is, with no command.

    Errors are measured by that of the run; where it diverged, by the largest demand.
    """
    like = loop.machine(loop.init())
    samples = run[COMMAND].size - 1
    states = np.repeat(np.array(values(like))[:, np.newaxis], samples + 1, axis=1)
    error = largest_or_one(run[DEMAND].values) if run["diverged"] else run_error(run)
    scales = ProblemScales(np.array([one for _, one in state_sizes(like)]), limits.limit, error)
    return scaled_beginning(loop, limits, states, np.zeros(samples), scales)


def scaled_beginning(
    loop: Loop, limits: CommandLimits, states: NDArray[np.float64], commands: Vector, scales: ProblemScales
) -> Beginning:
    """A course of states and commands in SI units."""
    course, commands = states / scales.machine[:, np.newaxis], commands / scales.command
    if remembers_command(loop, limits):
        first = float(loop.init().controller.u) / scales.command
        course = np.vstack([course, np.append(first, commands)])
    return Beginning(Course(course, commands), scales)


def run_error(run: "xr.Dataset") -> float:
    """The rms error of a run, and 1 where it is 0."""
    return float(run["rms_error"]) or 1.0


def largest_or_one(values: Vector) -> float:
    """The largest size of some numbers, and 1 where all are 0 or none is there."""
    return float(np.nanmax(np.abs(values), initial=0.0)) or 1.0


class BestRuns(NamedTuple):
    """The runs of the best commands: to which jumps are known once they are there, and to which all is."""

    causal: Any  # datasets of xarray, which is heavy to import
    clairvoyant: Any


def best_commands(
    loop: Loop, limits: CommandLimits, begin: Beginning, report: RunProgress, threads: int
) -> BestRuns:
    """The commands with the least squared error, played back."""
    samples = checked_samples(loop)
    one = period_model(loop, begin.scales, remembers_command(loop, limits))
    search = LimitSearch(loop, one, limits, foreknowledge(loop, samples), threads)
    causal = search.causal(begin.course, lambda done: report(CAUSAL * done / samples))
    none = len(surprises(search.known, limits, samples)) == 2  # but the start and the end
    clairvoyant = causal if none else search.clairvoyant(causal.course)
    report(1.0)
    runs = [search.played(found) for found in (causal, clairvoyant)]
    size = begin.scales.error
    return BestRuns(runs[0], with_sought_error(runs[1], size * math.sqrt(clairvoyant.squares), size))


class LimitSearch(NamedTuple):
    """What a limit is sought in."""

    loop: Loop
    one: PeriodModel
    limits: CommandLimits
    known: Foreknowledge
    threads: int

    def clairvoyant(self, guess: Course) -> Optimum:
        table = self.known.table(0, guess.commands.size)
        return optimum(self.one, self.limits, table, guess, self.threads)

    def causal(self, guess: Course, done: SamplesDone) -> Optimum:
        """The stretches between jumps, one after the other."""
        parts = list(self.stretches(guess, done))
        states = [parts[0].course.states[:, :1], *(part.course.states[:, 1:] for part in parts)]
        course = Course(np.hstack(states), np.concatenate([part.course.commands for part in parts]))
        squares = math.fsum(part.squares for part in parts)
        return Optimum(
            course, squares, sum(part.iterations for part in parts), all(p.converged for p in parts)
        )

    def stretches(self, guess: Course, done: SamplesDone) -> Iterator[Optimum]:
        """The commands of a controller that knows all but the jumps to come, a stretch between two at a time.

        From the state in which a jump finds the machine, the commands are those that would leave the least
        squared error if the demand went on at its rate, and the load stayed, for a tenth longer than they do.
        Each optimum is cut where the next jump is known.
        """
        samples, state = guess.commands.size, guess.states[:, 0]
        for first, last in pairwise(surprises(self.known, self.limits, samples)):
            tail = max(math.ceil(TAIL * (last - first)), LEAST_TAIL)
            end = min(last + tail, samples)
            known_from = max(first - self.limits.late, 0) * self.known.substeps + 1
            begin = guess.part(first, end)
            begin = begin._replace(states=np.column_stack([state, begin.states[:, 1:]]))
            table = expected_course(self.known, known_from).table(first, end)
            found = optimum(self.one, self.limits, table, begin, self.threads)
            state = found.course.states[:, last - first].copy()
            done(last)
            yield found._replace(course=found.course.part(0, last - first))

    def played(self, found: Optimum) -> "xr.Dataset":
        """The run that a found command makes."""
        commands = self.one.command_scale * found.course.commands
        law = Playback(np.append(commands, commands[-1]), float(self.loop.init().controller.u))
        data = limit_run(self.loop._replace(controller=law))
        said = data.assign_attrs(iterations=found.iterations, converged=found.converged)
        stopped = f"the search stopped after {found.iterations} iterations, short of an optimum"
        return with_warning(said, [] if found.converged else [stopped])


def with_sought_error(data: "xr.Dataset", sought: float, size: float) -> "xr.Dataset":
    """A run with what its search says that it leaves, and a warning if it leaves something else."""
    left = float(data["rms_error"])
    unit = data["rms_error"].attrs["units"]
    said = f"played back, the command leaves {left:.5g} {unit} and not the {sought:.5g} {unit} of its search"
    return with_warning(
        data.assign_attrs(sought_rms_error=sought), [said] if abs(left - sought) > APART * size else []
    )


def loop_to_limit(loop: Loop) -> Loop:
    """A loop that is ready to run, and recorded at each sample."""
    if isinstance(loop.controls, Command):
        raise ParameterError(
            "controls", "Command", "is not a signal of the machine: an open loop has no limit"
        )
    refuse_fmus(loop, "find its limit")
    integrator = loop.simulation.integrator
    if not hasattr(integrator, "substep"):
        problem = "chooses its steps; a limit needs equal ones, such as RK4's"
        raise ParameterError("simulation.integrator", type(integrator).__name__, problem)
    recorded: Loop = replace(loop, {"simulation.record_period": loop.simulation.period})
    return runnable_loop(recorded)


def checked_samples(loop: Loop) -> int:
    """How many commands are sought."""
    begin = loop.init()
    samples = plan_of(loop, begin, ()).samples - 1
    most = MOST_UNKNOWNS // (len(values(loop.machine(begin))) + 1)
    if samples > most:
        problem = f"has {samples} samples, and a search takes up to {most} with this machine; shorten it"
        raise ParameterError("simulation.duration", loop.simulation.duration, problem)
    return samples


def limit_run(loop: Loop) -> "xr.Dataset":
    """A run of a loop, with its machine's states, judged by its tracking error alone."""
    paths = [path for path, _ in leaves(loop.machine(loop.init()))]
    record = [*paths, COMMAND, SIGNAL, DEMAND]
    return simulate(loop, record=list(dict.fromkeys(record)), metrics=[TrackingError()])


def surprises(known: Foreknowledge, limits: CommandLimits, samples: int) -> list[int]:
    """The samples whose commands are the first to tell of a jump, 0 and the end among them."""
    steps = np.unique(np.concatenate(jump_steps(known)))
    found = {math.ceil(int(step) / known.substeps) + limits.late for step in steps}
    return sorted({0, *(k for k in found if k < samples), samples})
