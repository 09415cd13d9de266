"""The search for the best commands of a loop, and the runs that they make."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydroservo.control.controlled import Command
from hydroservo.control.loop import Loop
from hydroservo.control.monitors import TrackingError
from hydroservo.core.block import leaves, replace, values
from hydroservo.core.errors import ParameterError
from hydroservo.cosimulation import refuse_fmus
from hydroservo.limits.beginning import COMMAND, DEMAND, Beginning, remembers
from hydroservo.limits.command import CommandLimits, Playback
from hydroservo.limits.foreknown import Foreknown, expected, foreknown, jumps
from hydroservo.limits.interval import Interval, interval
from hydroservo.limits.problem import Course, Optimum, optimum
from hydroservo.runs.cautions import with_warning
from hydroservo.runs.run import Progress, plan_of, ready, simulate

if TYPE_CHECKING:
    import xarray as xr

SIGNAL = "controlled.value"
MOST_UNKNOWNS = 10**6  # states and commands, of some kilobytes each
CAUSAL = 0.5  # of the work, that is done after it
APART = 1e-3  # of the size of errors, by which a command that is played back may miss what its search says

TAIL = 0.1  # of a stretch between jumps: how much longer it is expected to last
LEAST_TAIL = 20  # samples
Solved = Callable[[int], None]  # called with the samples that are done


class Best(NamedTuple):
    """The runs of the best commands: to which jumps are known once they are there, and to which all is."""

    causal: Any  # datasets of xarray, which is heavy to import
    clairvoyant: Any


def best_commands(
    loop: Loop, limits: CommandLimits, begin: Beginning, report: Progress, threads: int
) -> Best:
    """The commands with the least squared error, played back.

    Args:
        loop: the loop, as :func:`prepared` gives it, its substeps a number.
        limits: of the command.
        begin: with what the search begins.
        report: called now and then with the fraction done.
        threads: on which samples are computed; no bit depends on it.
    """
    samples = checked_samples(loop)
    one = interval(loop, begin.scales, remembers(loop, limits))
    search = Search(loop, one, limits, foreknown(loop, samples), threads)
    causal = search.causal(begin.course, lambda done: report(CAUSAL * done / samples))
    none = len(surprises(search.known, limits, samples)) == 2  # but the start and the end
    clairvoyant = causal if none else search.clairvoyant(causal.course)
    report(1.0)
    runs = [search.played(found) for found in (causal, clairvoyant)]
    size = begin.scales.error
    return Best(runs[0], compared(runs[1], size * math.sqrt(clairvoyant.squares), size))


class Search(NamedTuple):
    """What a limit is sought in."""

    loop: Loop
    one: Interval
    limits: CommandLimits
    known: Foreknown
    threads: int

    def clairvoyant(self, guess: Course) -> Optimum:
        table = self.known.table(0, guess.commands.size)
        return optimum(self.one, self.limits, table, guess, self.threads)

    def causal(self, guess: Course, done: Progress) -> Optimum:
        """The stretches between jumps, one after the other."""
        parts = list(causal_course(self.one, self.limits, self.known, guess, self.threads, done))
        states = [parts[0].course.states[:, :1], *(part.course.states[:, 1:] for part in parts)]
        course = Course(np.hstack(states), np.concatenate([part.course.commands for part in parts]))
        squares = math.fsum(part.squares for part in parts)
        return Optimum(
            course, squares, sum(part.iterations for part in parts), all(p.converged for p in parts)
        )

    def played(self, found: Optimum) -> "xr.Dataset":
        """The run that a found command makes."""
        commands = self.one.command_scale * found.course.commands
        law = Playback(np.append(commands, commands[-1]), float(self.loop.init().controller.u))
        data = run_of(self.loop._replace(controller=law))
        said = data.assign_attrs(iterations=found.iterations, converged=found.converged)
        stopped = f"the search stopped after {found.iterations} iterations, short of an optimum"
        return with_warning(said, [] if found.converged else [stopped])


def compared(data: "xr.Dataset", sought: float, size: float) -> "xr.Dataset":
    """A run with what its search says that it leaves, and a warning if it leaves something else.

    Args:
        data: the run.
        sought: the rms error that the search says.
        size: by a thousandth of which the two may differ.
    """
    left = float(data["rms_error"])
    unit = data["rms_error"].attrs["units"]
    said = f"played back, the command leaves {left:.5g} {unit} and not the {sought:.5g} {unit} of its search"
    return with_warning(
        data.assign_attrs(sought_rms_error=sought), [said] if abs(left - sought) > APART * size else []
    )


def prepared(loop: Loop) -> Loop:
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
    return ready(recorded)


def checked_samples(loop: Loop) -> int:
    """How many commands are sought."""
    begin = loop.init()
    samples = plan_of(loop, begin, ()).samples - 1
    most = MOST_UNKNOWNS // (len(values(loop.machine(begin))) + 1)
    if samples > most:
        problem = f"has {samples} samples, and a search takes up to {most} with this machine; shorten it"
        raise ParameterError("simulation.duration", loop.simulation.duration, problem)
    return samples


def run_of(loop: Loop) -> "xr.Dataset":
    """A run of a loop, with its machine's states, judged by its tracking error alone."""
    paths = [path for path, _ in leaves(loop.machine(loop.init()))]
    record = [*paths, COMMAND, SIGNAL, DEMAND]
    return simulate(loop, record=list(dict.fromkeys(record)), metrics=[TrackingError()])


def surprises(known: Foreknown, limits: CommandLimits, samples: int) -> list[int]:
    """The samples whose commands are the first to tell of a jump, 0 and the end among them."""
    steps = np.unique(np.concatenate(jumps(known)))
    found = {math.ceil(int(step) / known.substeps) + limits.late for step in steps}
    return sorted({0, *(k for k in found if k < samples), samples})


def causal_course(
    one: Interval, limits: CommandLimits, known: Foreknown, guess: Course, threads: int, done: Solved
) -> Iterator[Optimum]:
    """The commands of a controller that knows all but the jumps to come, a stretch between two at a time.

    From the state in which a jump finds the machine, the commands are those that would leave the least
    squared error if the demand went on at its rate, and the load stayed, for a tenth longer than they do.

    Yields:
        The optimum of each stretch, cut where the next jump is known.
    """
    samples = guess.commands.size
    state = guess.states[:, 0]
    for first, last in pairwise(surprises(known, limits, samples)):
        tail = max(math.ceil(TAIL * (last - first)), LEAST_TAIL)
        end = min(last + tail, samples)
        told = max(first - limits.late, 0) * known.substeps
        begin = guess.part(first, end)
        begin = begin._replace(states=np.column_stack([state, begin.states[:, 1:]]))
        seen = expected(known, told + 1)
        found = optimum(one, limits, seen.table(first, end), begin, threads)
        state = found.course.states[:, last - first].copy()
        done(last)
        yield found._replace(course=found.course.part(0, last - first))
