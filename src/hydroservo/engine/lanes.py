"""Many runs side by side: one lane a run, in vectors of the processor.

The memory of a group holds LANES numbers for each varied parameter, each number of the states and of the
monitors, so that a loop over lanes loads, computes and stores whole vectors. Only loading and storing are
written for lanes; all else is the text that single runs use, so that a lane of strict machine code gives a
single run's bits. Other machine code differs in the last digits: lanes divide by reciprocals that stay.
"""

import ctypes
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, leaves
from hydroservo.engine import flat
from hydroservo.engine.kernel import Recording, RunSpec, mover
from hydroservo.engine.native import MachineCode, Native, RunError, c_argument, native_kernel
from hydroservo.engine.recipe import KernelKey
from hydroservo.engine.watch import MonitorGroups, is_silent, listener

LANES = 32  # four vectors of eight: enough to hide latencies, few enough for the states to stay in cache

CACHE_LINE = 8  # doubles


class LaneLayout(NamedTuple):
    """Where each part stands in the memory of a group, in rows of one number for each lane."""

    varied: tuple[str, ...]  # from row 0 on: the varied paths of the system
    states: int
    sums: int  # of the monitors that hear samples
    step_sums: int  # of those that hear steps
    alive: int


def lane_layout(varied: tuple[str, ...], state: Block, sums: MonitorGroups) -> LaneLayout:
    """The layout of runs that differ at these paths."""
    states = len(varied)
    first = states + len(list(leaves(state)))
    second = first + len(list(leaves(sums.samples)))
    return LaneLayout(varied, states, first, second, second + len(list(leaves(sums.steps))))


class CompiledLanes:
    """The kernel of a study whose runs differ in some numbers of the system."""

    def __init__(
        self, study: RunSpec, wanted: Recording, state: Block, varied: tuple[str, ...], *, strict: bool
    ):
        sums = study.watch.init()
        self.layout = lane_layout(varied, state, sums)
        recipe = KernelKey("lanes", (*map(flat.block_shape, (study, state, sums)), *wanted, varied), strict)
        self.call = native_kernel(
            recipe, lambda: compiled_lanes(study, wanted, state, sums, self.layout, strict)
        )
        self.study, self.state, self.first_sums = study, state, flat.block_numbers(sums)
        self.constants, self.tables = flat.block_numbers(study), flat.block_arrays(study)


class LaneGroup:
    """LANES runs at their first sample."""

    def __init__(self, kernel: CompiledLanes, parameters: Mapping[str, NDArray[np.float64]]) -> None:
        layout = kernel.layout
        self.kernel = kernel
        self.memory = aligned_rows(layout.alive + 1)
        for row, path in enumerate(layout.varied):
            self.memory[row] = np.resize(parameters[path], LANES)
            self.memory[row, parameters[path].size :] = parameters[path][-1]
        self.memory[layout.sums : layout.alive] = kernel.first_sums[:, np.newaxis]
        self.memory[layout.alive] = 1.0
        self.lost = np.zeros(LANES, dtype=bool)
        self.done = np.zeros(LANES, dtype=np.int64)  # samples, the one that lost a run not among them
        self.sums = self.memory[layout.sums : layout.alive].copy()
        self.states = self.memory[layout.states : layout.sums].copy()

    def advance(self, first: int, last: int, dt: float) -> None:
        """Samples first to last-1 in every lane. A lane whose state is lost runs on; what it had stays."""
        call: Native = self.kernel.call
        while first < last:
            first = call(self.kernel.constants, self.kernel.tables, self.memory, first, last, dt)
            self.keep(first)

    def keep(self, done: int) -> None:
        """Take over what the lanes have that are not lost yet, once so many samples are done."""
        layout = self.kernel.layout
        going, self.lost = ~self.lost, self.memory[layout.alive] == 0.0
        self.sums[:, going] = self.memory[layout.sums : layout.alive, going]
        self.states[:, going] = self.memory[layout.states : layout.sums, going]
        self.done[going] = done - self.lost[going]


def aligned_rows(rows: int) -> NDArray[np.float64]:
    """Rows of zeros that start on cache lines: a vector across two of them takes twice as long to load."""
    numbers = np.zeros(rows * LANES + CACHE_LINE)
    start = -numbers.ctypes.data // numbers.itemsize % CACHE_LINE
    return numbers[start : start + rows * LANES].reshape(rows, LANES)


def compiled_lanes(
    study: RunSpec, wanted: Recording, state: Block, sums: MonitorGroups, layout: LaneLayout, strict: bool
) -> MachineCode:
    from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS, kernel_text
    from hydroservo.engine.machine_code import object_code
    from hydroservo.language.terms import INT, REAL

    build, lane_of = flat.builder(study), varier(study.system, layout.varied, lane_index(0))
    states, steps = state_rows(state, layout.states), state_rows(sums.steps, layout.step_sums)
    begin_all, sample_all = beginner(lane_of, states), sampler(lane_of, states)
    hear_all = hearer(study.watch.samples, lane_of, states, state_rows(sums.samples, layout.sums), at_sample)
    first_all, next_all = movers(study, lane_of, states, steps)
    lose_all = divergence_marker(wanted, states, layout.alive * LANES)

    def advance(constants, tables, memory, first, last, dt):  # type: ignore[no-untyped-def]
        """Samples first to last-1, or until a lane's state is lost; returns the sample to go on with."""
        system, integrator, periods, substeps, watch = build(constants, tables)
        if first == 0:
            begin_all(system, memory)
        for k in range(first, last):
            t, h = k * dt, dt / substeps if k < periods else 0.0
            sample_all(system, memory, t, dt)
            hear_all(watch.samples, system, memory, t, dt)
            first_all(watch.steps, system, integrator, memory, t, h, dt, substeps)
            if k >= periods:
                return last
            for i in range(1, substeps):
                next_all(watch.steps, system, integrator, memory, t + i * h, h)
            if lose_all(memory):
                return k + 1
        return last

    text = kernel_text(advance.__name__, advance, (DOUBLES, INTEGERS, DOUBLES, INT, INT, REAL))
    return object_code(advance.__name__, text, strict, reciprocals=not strict)


class Rows(NamedTuple):
    """What loads a lane's state from its rows, and what stores it there."""

    load: Callable[..., Any]
    store: Callable[..., Any]


def state_rows(state: Block, first: int) -> Rows:
    return Rows(flat.loader(state, lane_index(first)), flat.storer(state, lane_index(first)))


def beginner(lane_of: Callable[..., Any], states: Rows) -> Callable[..., None]:
    """What puts every lane at its start."""
    store = states.store

    def begin(system, memory):  # type: ignore[no-untyped-def]
        for lane in range(LANES):
            store(memory, lane, lane_of(system, memory, lane).init())

    return begin


def sampler(lane_of: Callable[..., Any], states: Rows) -> Callable[..., None]:
    load, store = states

    def sample(system, memory, t, dt):  # type: ignore[no-untyped-def]
        for lane in range(LANES):
            store(memory, lane, lane_of(system, memory, lane).sample(load(memory, lane), t, dt))

    return sample


def hearer(
    watch: Block, lane_of: Callable[..., Any], states: Rows, sums: Rows, seen: Callable[..., Any]
) -> Callable[..., None]:
    """What lets the monitors of every lane hear what is ``seen`` there; loops of their own suit vectors."""
    hear, see, load, load_sums, store_sums = listener(watch), seen, states.load, *sums

    def heard(w, system, memory, t, dt):  # type: ignore[no-untyped-def]
        for lane in range(LANES):
            own, m = lane_of(system, memory, lane), load_sums(memory, lane)
            store_sums(memory, lane, hear(w, m, own, see(own, load(memory, lane), t), t, dt))

    return heard


def at_sample(_own, s, _t):  # type: ignore[no-untyped-def]
    """The state at a sample."""
    return s


def between_samples(own, s, t):  # type: ignore[no-untyped-def]
    """The state between samples."""
    return own.between(s, own.machine(s), t)


def movers(
    study: RunSpec, lane_of: Callable[..., Any], states: Rows, sums: Rows
) -> tuple[Callable[..., None], Callable[..., None]]:
    """What takes every lane through the first step of a sample period, and through another.

    Monitors hear each step; where h is 0 the run is at its end, and nothing moves. Equal steps go through all
    lanes one by one, for vectors have no loops of their own; an integrator that chooses its steps takes them
    all at the first, lane by lane.
    """
    load, store = states
    load_sums, store_sums = sums
    at_once, between = (
        hearer(study.watch.steps, lane_of, states, sums, seen) for seen in (at_sample, between_samples)
    )
    hear = not is_silent(study.watch.steps)
    all_steps = mover(study)

    def step(system: Block, integrator: Block, memory: Any, t: float, h: float) -> None:
        for lane in range(LANES):
            own, s = lane_of(system, memory, lane), load(memory, lane)
            x = integrator.substep(own, t, own.machine(s), own.held(s), h)
            store(memory, lane, own.with_machine(s, x))

    def first_step(w, system, integrator, memory, t, h, _dt, _substeps):  # type: ignore[no-untyped-def]
        at_once(w, system, memory, t, h)
        if h > 0.0:
            step(system, integrator, memory, t, h)

    def next_step(w, system, integrator, memory, t, h):  # type: ignore[no-untyped-def]
        if hear:
            between(w, system, memory, t, h)
        step(system, integrator, memory, t, h)

    def every_step(w, system, integrator, memory, t, h, dt, substeps):  # type: ignore[no-untyped-def]
        if h > 0.0:
            for lane in range(LANES):
                own, s = lane_of(system, memory, lane), load(memory, lane)
                m = load_sums(memory, lane)
                x, m = all_steps(own, integrator, w, m, s, t, dt, substeps)
                store(memory, lane, own.with_machine(s, x))
                store_sums(memory, lane, m)
        else:
            at_once(w, system, memory, t, h)

    def no_step(_w, _system, _integrator, _memory, _t, _h):  # type: ignore[no-untyped-def]
        pass

    equal = hasattr(type(study.integrator), "substep")
    return (first_step, next_step) if equal else (every_step, no_step)


def divergence_marker(wanted: Recording, states: Rows, alive: int) -> Callable[..., bool]:
    """What marks the lanes that are lost, and says whether one is that was not."""
    load, holds = states.load, flat.checker(wanted.watched, dict(wanted.reach))

    def lose(memory):  # type: ignore[no-untyped-def]
        lost = 0
        for lane in range(LANES):
            lost += int((memory[alive + lane] > 0.0) & (not holds(load(memory, lane))))
        if lost > 0:
            for lane in range(LANES):
                if not holds(load(memory, lane)):
                    memory[alive + lane] = 0.0
        return lost > 0

    return lose


def lane_index(first: int) -> flat.Place:
    """The index of a lane's number in the i-th row from one on."""
    return lambda i: f"{(first + i) * LANES} + lane"


def varier(block: Block, varied: tuple[str, ...], place: flat.Place) -> Callable[..., Any]:
    """A function ``vary(block, memory, lane)`` that returns the block with a lane's own parameters.

    ``place`` gives the index of the i-th number.
    """

    def text(path: str, value: Any) -> str:
        if path not in varied:
            return f"block.{path}"
        number = f"memory[{place(varied.index(path))}]"
        return f"int({number})" if isinstance(value, int) else number

    return flat.constructor("vary(block, memory, lane)", block, text)


def monitor_traces(
    kernel: CompiledLanes,
    parameters: Mapping[str, NDArray[np.float64]],
    samples: int,
    dt: float,
    after: Callable[[int, NDArray[np.float64]], None] | None = None,
) -> NDArray[np.float64]:
    """What the monitors that hear samples hold after each sample, shape (samples, numbers, LANES).

    Lanes beyond the runs given repeat the last of these; a lane whose state was lost is nan throughout.

    Args:
        kernel: of a study of so many samples.
        parameters: arrays of shape (runs,), of at most LANES runs, by path.
        samples: of each run.
        dt: between them [s].
        after: called with the number of each sample once the machine has moved on from it, and the memory of
            the lanes, in which it may change states and parameters.
    """
    group, layout = LaneGroup(kernel, parameters), kernel.layout
    held, alive = group.memory[layout.sums : layout.step_sums], group.memory[layout.alive]
    advance = bind_arrays(kernel.call, kernel.constants, kernel.tables, group.memory)
    out = np.empty((samples, *held.shape))
    for k in range(samples):
        advance(k, k + 1, dt)
        out[k] = held
        if after is not None:
            after(k, group.memory)
    out[:, :, alive == 0.0] = np.nan
    return out


def bind_arrays(call: Native, *arrays: NDArray[Any]) -> Callable[[int, int, float], None]:
    """A kernel whose arrays stay where they are: what it takes besides is quick to give."""
    result = ctypes.c_int64()
    places = (ctypes.byref(result), *map(c_argument, arrays))
    function, whole, real = call.function, ctypes.c_int64, ctypes.c_double

    def advance(first: int, last: int, dt: float) -> None:
        if function(*places, whole(first), whole(last), real(dt)) != 0:
            raise RunError("a block raised an exception, which compiled code cannot carry")

    return advance
