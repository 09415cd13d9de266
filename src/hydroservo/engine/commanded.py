"""Many runs side by side that are given their commands from outside, one sample period a call.

The memory of a group is that of :mod:`~hydroservo.engine.lanes`, with two rows more: the number of the sample
that each lane is at, for each may begin anew when it likes, and whether its state still holds. A call goes
through many groups, so that Python is asked once and not once a group.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, leaves
from hydroservo.engine import flat
from hydroservo.engine.kernel import Recording, RunSpec, mover
from hydroservo.engine.lanes import LANES, aligned_rows, lane_index, varier
from hydroservo.engine.native import MachineCode, native_kernel
from hydroservo.engine.recipe import KernelKey

Numbers = NDArray[np.float64]
Whole = NDArray[np.int64]


class StepLayout(NamedTuple):
    """Where each part stands in the memory of a group, in rows of one number for each lane."""

    states: int  # after the varied numbers of the system
    command: int  # in the states, the number that is given from outside
    sample: int  # the number of the sample that a lane is at
    alive: int

    @property
    def size(self) -> int:
        """Numbers of a group."""
        return (self.alive + 1) * LANES


def step_layout(varied: Sequence[str], state: Block, command: str) -> StepLayout:
    """Where a group of runs that differ in some numbers has its parts."""
    paths = [path for path, _ in leaves(state)]
    sample = len(varied) + len(paths)
    return StepLayout(len(varied), len(varied) + paths.index(command), sample, sample + 1)


class CompiledSteps:
    """The kernels of a study: one that begins runs, and one that takes them through a sample period.

    Args:
        study: without monitors.
        wanted: what to show of each sample, by path in the state s, and what must hold of it.
        state: the first.
        varied: the paths of the system in which runs differ.
        command: the path in the state of what is given from outside.
    """

    def __init__(
        self, study: RunSpec, wanted: Recording, state: Block, varied: tuple[str, ...], command: str
    ):
        self.varied, self.places = varied, step_layout(varied, state, command)
        self.width = len(wanted.recorded)
        self.arguments = study, wanted, state, varied, command
        shapes = (*map(flat.block_shape, (study, state)), *wanted, varied, command)
        made = StepSpec(study, wanted, state, varied, self.places)
        begin, step = (KernelKey(name, shapes, strict=True) for name in ("first samples", "sample periods"))
        self.begin = native_kernel(begin, lambda: compiled_begin(made))
        self.step = native_kernel(step, lambda: compiled_step(made))
        self.study = study  # kept alive: the table of arrays points into it
        self.constants, self.tables = flat.block_numbers(study), flat.block_arrays(study)

    def __reduce__(self) -> tuple[Any, ...]:
        """Machine code belongs to its process: another one makes it again, or finds it on disk."""
        return CompiledSteps, self.arguments

    def __deepcopy__(self, memo: object) -> "CompiledSteps":
        """Itself, for it never changes."""
        return self


class StepSpec(NamedTuple):
    """What the text of both kernels is written from."""

    study: RunSpec
    wanted: Recording
    state: Block
    varied: tuple[str, ...]
    places: StepLayout


class Steps:
    """So many runs, none begun.

    Attributes:
        groups: of LANES runs that they are.
        shown: what is wanted of each run at its last sample, shape (runs, numbers).
    """

    def __init__(self, kernel: CompiledSteps, runs: int) -> None:
        self.kernel, self.runs, self.groups = kernel, runs, -(-runs // LANES)
        self.memory = aligned_rows(self.groups * kernel.places.size // LANES).reshape(-1)
        self.rows = self.memory.reshape(self.groups, -1, LANES)
        self.shown = np.zeros((runs, kernel.width))

    def __getstate__(self) -> tuple[Any, ...]:
        return self.kernel, self.runs, self.memory, self.shown

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        kernel, runs, memory, shown = state
        self.__init__(kernel, runs)  # type: ignore[misc]  # whose memory starts on cache lines
        self.memory[:], self.shown[:] = memory, shown

    def give(self, which: Whole, numbers: Numbers) -> None:
        """Give some runs their varied numbers, shape (numbers, runs)."""
        self.rows[which // LANES, : self.kernel.places.states, which % LANES] = numbers.T

    def command(self, values: Numbers) -> None:
        """Give each run what comes from outside, until it is given something else."""
        row, (full, rest) = self.rows[:, self.kernel.places.command], divmod(self.runs, LANES)
        row[:full] = values[: full * LANES].reshape(full, LANES)
        if rest:
            row[full, :rest] = values[full * LANES :]

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Whether the state of each run ceased to hold since it began."""
        found: NDArray[np.bool_] = self.rows[:, self.kernel.places.alive].reshape(-1)[: self.runs] == 0.0
        return found

    def begin(self, which: Whole, dt: float) -> None:
        """The first sample of some runs, of those with these numbers."""
        kernel, chosen = self.kernel, np.ascontiguousarray(which)
        kernel.begin(kernel.constants, kernel.tables, self.memory, self.shown, chosen, chosen.size, dt)

    def advance(self, first: int, last: int, dt: float) -> None:
        """A sample period of all runs in groups first to last-1, and the sample at its end."""
        kernel = self.kernel
        kernel.step(kernel.constants, kernel.tables, self.memory, self.shown, first, last, self.runs, dt)


def compiled_begin(made: StepSpec) -> MachineCode:
    from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS
    from hydroservo.engine.machine_code import machine_code
    from hydroservo.language.terms import INT, REAL

    build, store = flat.builder(made.study), run_storer(made)
    record, lane_of = run_recorder(made), varied_of(made)
    size, sample, alive = made.places.size, made.places.sample * LANES, made.places.alive * LANES

    def begin(constants, tables, memory, shown, which, count, dt):  # type: ignore[no-untyped-def]
        system = build(constants, tables).system
        for i in range(count):
            run = which[i]
            lane = run // LANES * size + run % LANES
            own = lane_of(system, memory, lane)
            s = own.sample(own.init(), 0.0, dt)
            store(memory, lane, s)
            memory[sample + lane] = 0.0
            memory[alive + lane] = 1.0
            record(shown, run, s, s)
        return 0

    memory = (DOUBLES, INTEGERS, DOUBLES, DOUBLES, INTEGERS)
    return machine_code(begin, (*memory, INT, REAL), strict=True)


def compiled_step(made: StepSpec) -> MachineCode:
    from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS
    from hydroservo.engine.machine_code import machine_code
    from hydroservo.language.terms import INT, REAL

    build, load, record = flat.builder(made.study), state_of(made), run_recorder(made)
    move_all, sample_all, size = machine_mover(made), state_sampler(made), made.places.size

    def advance(constants, tables, memory, shown, first, last, runs, dt):  # type: ignore[no-untyped-def]
        study = build(constants, tables)
        for group in range(first, last):
            at = group * size
            end = at + min(LANES, runs - group * LANES)
            move_all(study, memory, at, end, dt)
            sample_all(study.system, memory, at, end, dt)
            for lane in range(at, end):
                s = load(memory, lane)
                record(shown, group * LANES + lane - at, s, s)
        return 0

    memory = (DOUBLES, INTEGERS, DOUBLES, DOUBLES)
    return machine_code(advance, (*memory, INT, INT, INT, REAL), strict=True)


def machine_mover(made: StepSpec) -> Callable[..., None]:
    """What takes the machines of a group from their samples to the next.

    Equal steps go through all lanes one by one, for vectors have no loops of their own; an integrator that
    chooses its steps takes them all lane by lane.
    """
    load, store, lane_of = state_of(made), run_storer(made), varied_of(made)
    sample, whole = made.places.sample * LANES, mover(made.study)

    def equal_steps(study, memory, at, end, dt):  # type: ignore[no-untyped-def]
        h = dt / study.substeps
        for i in range(study.substeps):
            for lane in range(at, end):
                own, s = lane_of(study.system, memory, lane), load(memory, lane)
                t = memory[sample + lane] * dt + i * h
                x = study.integrator.substep(own, t, own.machine(s), own.held(s), h)
                store(memory, lane, own.with_machine(s, x))

    def chosen_steps(study, memory, at, end, dt):  # type: ignore[no-untyped-def]
        for lane in range(at, end):
            own, s = lane_of(study.system, memory, lane), load(memory, lane)
            t, unheard = memory[sample + lane] * dt, study.watch.steps
            x, _ = whole(own, study.integrator, unheard, unheard, s, t, dt, study.substeps)
            store(memory, lane, own.with_machine(s, x))

    return equal_steps if hasattr(type(made.study.integrator), "substep") else chosen_steps


def state_sampler(made: StepSpec) -> Callable[..., None]:
    """What judges the states of a group and samples them."""
    load, store, lane_of = state_of(made), run_storer(made), varied_of(made)
    holds = flat.checker(made.wanted.watched, dict(made.wanted.reach))
    sample, alive = made.places.sample * LANES, made.places.alive * LANES

    def sample_all(system, memory, at, end, dt):  # type: ignore[no-untyped-def]
        for lane in range(at, end):
            own, s = lane_of(system, memory, lane), load(memory, lane)
            memory[alive + lane] = memory[alive + lane] if holds(s) else 0.0
            memory[sample + lane] += 1.0
            store(memory, lane, own.sample(s, memory[sample + lane] * dt, dt))

    return sample_all


def state_of(made: StepSpec) -> Callable[..., Any]:
    """A function ``load(memory, lane)`` that returns a lane's state."""
    return flat.loader(made.state, lane_index(made.places.states))


def run_storer(made: StepSpec) -> Callable[..., Any]:
    """A function ``store(memory, lane, s)`` that writes it."""
    return flat.storer(made.state, lane_index(made.places.states))


def varied_of(made: StepSpec) -> Callable[..., Any]:
    """A function ``vary(system, memory, lane)`` that returns a lane's own system."""
    return varier(made.study.system, made.varied, lane_index(0))


def run_recorder(made: StepSpec) -> Callable[..., Any]:
    """A function ``record(shown, run, s, s)`` that writes what is wanted of a state."""
    return flat.recorder(made.wanted.recorded)
