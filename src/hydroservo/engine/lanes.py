"""Many runs side by side: one lane a run, in vectors of the processor.

The memory of a group holds LANES numbers for each varied parameter, each number of the states and of the
metrics, so that a loop over lanes loads, computes and stores whole vectors. Only loading and storing are
written for lanes; all else is the text that single runs use, so that a lane gives a single run's bits.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block, leaves
from hydroservo.engine import flat
from hydroservo.engine.kernel import Study, Wanted
from hydroservo.engine.native import MachineCode, Native, native
from hydroservo.engine.recipe import Recipe

__all__ = ["LANES", "CompiledLanes", "Group", "Layout", "layout_of", "loader", "varier"]

LANES = 32  # four vectors of eight: enough to hide latencies, few enough for the states to stay in cache

CACHE_LINE = 8  # doubles


class Layout(NamedTuple):
    """Where each part stands in the memory of a group, in rows of one number for each lane."""

    varied: tuple[str, ...]  # from row 0 on: the varied paths of the system
    states: int
    sums: int
    alive: int


def layout_of(varied: tuple[str, ...], state: Block, sums: Block) -> Layout:
    """The layout of runs that differ at these paths."""
    states = len(varied)
    first = states + len(list(leaves(state)))
    return Layout(varied, states, first, first + len(list(leaves(sums))))


class CompiledLanes:
    """The kernel of a study whose runs differ in some numbers of the system."""

    def __init__(self, study: Study, wanted: Wanted, state: Block, varied: tuple[str, ...], *, strict: bool):
        sums = study.metrics.init()
        self.layout = layout_of(varied, state, sums)
        recipe = Recipe("lanes", (*map(flat.shape, (study, state, sums)), *wanted, varied), strict)
        self.call = native(recipe, lambda: compiled_lanes(study, wanted, state, sums, self.layout, strict))
        self.study, self.state, self.first_sums = study, state, flat.numbers(sums)
        self.constants, self.tables = flat.numbers(study), flat.arrays(study)


class Group:
    """LANES runs at their first sample."""

    def __init__(self, kernel: CompiledLanes, parameters: Mapping[str, NDArray[np.float64]]) -> None:
        layout = kernel.layout
        self.kernel = kernel
        self.memory = aligned(layout.alive + 1)
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


def aligned(rows: int) -> NDArray[np.float64]:
    """Rows of zeros that start on cache lines: a vector across two of them takes twice as long to load."""
    numbers = np.zeros(rows * LANES + CACHE_LINE)
    start = -numbers.ctypes.data // numbers.itemsize % CACHE_LINE
    return numbers[start : start + rows * LANES].reshape(rows, LANES)


def compiled_lanes(
    study: Study, wanted: Wanted, state: Block, sums: Block, layout: Layout, strict: bool
) -> MachineCode:
    from hydroservo.engine.machine_code import DOUBLES, FLOAT, INTEGER, INTEGERS, inlined, machine_code

    build, lane_of = inlined(flat.builder(study)), inlined(varier(study.system, layout.varied, row(0)))
    state_of, sums_of = inlined(loader(state, row(layout.states))), inlined(loader(sums, row(layout.sums)))
    put_state = inlined(flat.storer(state, row(layout.states)))
    put_sums = inlined(flat.storer(sums, row(layout.sums)))
    put_machine = inlined(flat.storer(study.system.machine(state), row(layout.states)))
    read, sample, alive = inlined(flat.reader(wanted.measured)), wanted.sample, layout.alive * LANES
    finite = inlined(flat.checker(wanted.watched))
    begin, go_on = steps_of(study.integrator)

    def advance(constants, tables, memory, first, last, dt):  # type: ignore[no-untyped-def]
        """Samples first to last-1, or until a lane's state is lost; returns the sample to go on with."""
        system, integrator, substeps, metrics = build(constants, tables)
        if first == 0:
            for lane in range(LANES):
                put_state(memory, lane, lane_of(system, memory, lane).init())
        for k in range(first, last):
            t = k * dt
            for lane in range(LANES):
                own = lane_of(system, memory, lane)
                s = own.sample(state_of(memory, lane), t, dt)
                put_sums(memory, lane, metrics.step(sums_of(memory, lane), t, sample(*read(s))))
                x = begin(integrator, own, t, own.machine(s), own.held(s), dt, substeps)
                put_state(memory, lane, own.moved(s, x))
            for i in range(1, substeps):
                for lane in range(LANES):
                    own = lane_of(system, memory, lane)
                    s = state_of(memory, lane)
                    x = go_on(integrator, own, t, own.machine(s), own.held(s), dt, substeps, i)
                    put_machine(memory, lane, x)
            lost = 0
            for lane in range(LANES):
                lost += 1 if memory[alive + lane] > 0.0 and not finite(state_of(memory, lane)) else 0
            if lost > 0:
                for lane in range(LANES):
                    if not finite(state_of(memory, lane)):
                        memory[alive + lane] = 0.0
                return k + 1
        return last

    return machine_code(advance, (DOUBLES, INTEGERS, DOUBLES, INTEGER, INTEGER, FLOAT), strict)


def steps_of(integrator: Block) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """The first step of a sample period and the i-th one after it.

    Equal substeps go through all lanes one by one, for vectors have no loops of their own; an integrator
    that chooses its steps takes all of them at the first, lane by lane.
    """
    from hydroservo.engine.machine_code import inlined

    def first_substep(integrator, system, t, x, u, dt, substeps):  # type: ignore[no-untyped-def]
        return integrator.substep(system, t, x, u, dt / substeps)

    def substep(integrator, system, t, x, u, dt, substeps, i):  # type: ignore[no-untyped-def]
        h = dt / substeps
        return integrator.substep(system, t + i * h, x, u, h)

    def all_steps(integrator, system, t, x, u, dt, substeps):  # type: ignore[no-untyped-def]
        return integrator.advance(system, t, x, u, dt, substeps)

    def no_step(_integrator, _system, _t, x, *_):  # type: ignore[no-untyped-def]
        return x

    equal = hasattr(type(integrator), "substep")
    return (inlined(first_substep), inlined(substep)) if equal else (inlined(all_steps), inlined(no_step))


def row(first: int) -> flat.Place:
    """The index of a lane's number in the i-th row from one on."""
    return lambda i: f"{(first + i) * LANES} + lane"


def loader(block: Block, place: flat.Place) -> Callable[..., Any]:
    """A function ``load(memory, lane)`` that returns a lane's state.

    ``place`` gives the index of the i-th number.
    """
    order = {path: i for i, (path, _) in enumerate(leaves(block))}
    return flat.constructor("load(memory, lane)", block, lambda path, _: f"memory[{place(order[path])}]")


def varier(block: Block, varied: tuple[str, ...], place: flat.Place) -> Callable[..., Any]:
    """A function ``vary(block, memory, lane)`` that returns the block with a lane's own parameters.

    ``place`` gives the index of the i-th number.
    """

    def text(path: str, value: Any) -> str:
        if path not in varied:
            return f"block.{path}"
        return flat.cast(f"memory[{place(varied.index(path))}]", value)

    return flat.constructor("vary(block, memory, lane)", block, text)
