"""The loop over samples of one run: one text, interpreted or compiled."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block
from hydroservo.core.errors import HydroservoError
from hydroservo.core.states import filled
from hydroservo.engine import flat
from hydroservo.engine.native import MachineCode, RunError, native_kernel
from hydroservo.engine.recipe import KernelKey
from hydroservo.engine.watch import MonitorGroups, is_silent, listener

Out = NDArray[np.float64]


class RunSpec(NamedTuple):
    """All that is constant in a run."""

    system: Block
    integrator: Block
    periods: int  # of sampling; the last sample is the end
    substeps: int
    watch: MonitorGroups


class Recording(NamedTuple):
    """What to record of each sample, which numbers of a state must stay finite, and how large some may be."""

    recorded: tuple[str, ...]  # such as s.plant.velocity of the state s, or of the monitors' state m
    watched: tuple[str, ...]
    reach: tuple[tuple[str, float], ...]


class InterpretedRun:
    """A run in plain Python, to step through."""

    def __init__(self, study: RunSpec, wanted: Recording, state: Block) -> None:
        self.study, self.state, self.sums = study, state, study.watch.init()
        self.width = len(wanted.recorded)
        self.kernel = sample_kernel(study, wanted)

    def advance(self, first: int, last: int, dt: float, stride: int, out: Out) -> int:
        """Samples first to last-1; returns last, or the sample after which a watched number was lost.

        Rows of out: the samples that stride divides.
        """
        check_rows(first, last, stride, out, self.width)
        states = (self.state, self.sums)
        try:
            self.state, self.sums, done = self.kernel(
                *self.study, *states, first, last, dt, stride, out.reshape(-1)
            )
        except HydroservoError:  # which says all in a line
            raise
        except Exception as error:  # whatever a block stumbles over
            raise RunError(f"{type(error).__name__}: {error}") from error
        return done


class CompiledRun:
    """The same run in machine code, compiled for each new combination of blocks."""

    def __init__(self, study: RunSpec, wanted: Recording, state: Block, *, strict: bool) -> None:
        sums = study.watch.init()
        shapes = (*map(flat.block_shape, (study, state, sums)), *wanted, has_single_steps(study))
        recipe = KernelKey("run", shapes, strict)
        self.call = native_kernel(recipe, lambda: compiled_run(study, wanted, state, sums, strict))
        self.width = len(wanted.recorded)
        self.study, self.shapes = study, (state, sums)  # kept alive: the table of arrays points into it
        self.constants, self.tables = flat.block_numbers(study), flat.block_arrays(study)
        self.states, self.running = flat.block_numbers(state), flat.block_numbers(sums)

    def advance(self, first: int, last: int, dt: float, stride: int, out: Out) -> int:
        """Samples first to last-1; returns last, or the sample after which a watched number was lost.

        Rows of out: the samples that stride divides.
        """
        check_rows(first, last, stride, out, self.width)
        memory = (self.constants, self.tables, self.states, self.running, out)
        return int(self.call(*memory, first, last, dt, stride))

    @property
    def state(self) -> Block:
        """The state after the last sample."""
        return filled(self.shapes[0], iter(self.states.tolist()))

    @property
    def sums(self) -> Block:
        """The state of the monitors after the last sample."""
        return filled(self.shapes[1], iter(self.running.tolist()))


def check_rows(first: int, last: int, stride: int, out: Out, width: int) -> None:
    """Refuse memory that does not hold what samples first to last-1 write there."""
    if stride < 1 or not 0 <= first <= last:
        raise ValueError(f"there are no samples {first} to {last}, every {stride}")
    rows = -(-last // stride) + (-first // stride)
    if out.ndim != 2 or out.shape[1] != width or out.shape[0] < rows:
        raise ValueError(f"{rows} rows of {width} numbers do not fit into an array of shape {out.shape}")
    if out.dtype != np.float64 or not out.flags.carray:
        raise ValueError("rows go into a contiguous, writeable array of doubles")


def compiled_run(
    study: RunSpec, wanted: Recording, state: Block, sums: MonitorGroups, strict: bool
) -> MachineCode:
    from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS
    from hydroservo.engine.machine_code import machine_code
    from hydroservo.language.terms import INT, REAL

    build, state_of, sums_of = map(flat.builder, (study, state, sums))
    put_state, put_sums = map(flat.storer, (state, sums))
    run = sample_kernel(study, wanted)

    def advance(constants, tables, states, running, out, first, last, dt, stride):  # type: ignore[no-untyped-def]
        system, integrator, periods, substeps, watch = build(constants, tables)
        s, m = state_of(states, tables), sums_of(running, tables)
        s, m, done = run(system, integrator, periods, substeps, watch, s, m, first, last, dt, stride, out)
        put_state(states, 0, s)
        put_sums(running, 0, m)
        return done

    memory = (DOUBLES, INTEGERS, DOUBLES, DOUBLES, DOUBLES)
    return machine_code(advance, (*memory, INT, INT, REAL, INT), strict)


def sample_kernel(study: RunSpec, wanted: Recording) -> Callable[..., tuple[Block, MonitorGroups, int]]:
    record, holds = flat.recorder(wanted.recorded), flat.checker(wanted.watched, dict(wanted.reach))
    hear_sample, hear_step = listener(study.watch.samples), listener(study.watch.steps)
    move = mover(study)

    def run(
        system: Block,
        integrator: Block,
        periods: int,
        substeps: int,
        watch: MonitorGroups,
        s: Block,
        m: MonitorGroups,
        first: int,
        last: int,
        dt: float,
        stride: int,
        out: Any,
    ) -> tuple[Block, MonitorGroups, int]:
        """Samples first to last-1, or up to the one after which a number of the state is lost.

        Rows of out are the samples that stride divides. Returns the state, the monitors' state, and the
        number of that sample; last if there was none.
        """
        row = 0
        for k in range(first, last):
            t = k * dt
            s = system.sample(s, t, dt)
            heard = hear_sample(watch.samples, m.samples, system, s, t, dt)
            m = MonitorGroups(heard, m.steps)
            if k % stride == 0:
                record(out, row, s, m)
                row += 1
            if k >= periods:
                return s, MonitorGroups(heard, hear_step(watch.steps, m.steps, system, s, t, 0.0)), last
            x, steps = move(system, integrator, watch.steps, m.steps, s, t, dt, substeps)
            s, m = system.with_machine(s, x), MonitorGroups(heard, steps)
            if not holds(s):
                return s, m, k
        return s, m, last

    return run


def has_single_steps(study: RunSpec) -> bool:
    """Whether each sample period is one step: a kernel of its own, without a loop."""
    return study.substeps == 1 and hasattr(type(study.integrator), "substep")


def mover(study: RunSpec) -> Callable[..., tuple[Block, Block]]:
    """A function that carries the machine from a sample to the next, with what monitors hear on the way."""
    hear = listener(study.watch.steps)

    def unheard(system, integrator, _watch, m, s, t, dt, substeps):  # type: ignore[no-untyped-def]
        return integrator.advance(system, t, system.machine(s), system.held(s), dt, substeps), m

    def single_step(system, integrator, watch, m, s, t, dt, _substeps):  # type: ignore[no-untyped-def]
        m = hear(watch, m, system, s, t, dt)
        return integrator.substep(system, t, system.machine(s), system.held(s), dt), m

    def equal_steps(system, integrator, watch, m, s, t, dt, substeps):  # type: ignore[no-untyped-def]
        x, u, h = system.machine(s), system.held(s), dt / substeps
        for i in range(substeps):
            now = t + i * h
            if i > 0:
                s = system.between(s, x, now)
            m = hear(watch, m, system, s, now, h)
            x = integrator.substep(system, now, x, u, h)
        return x, m

    def chosen_steps(system, integrator, watch, m, s, t, dt, substeps):  # type: ignore[no-untyped-def]
        x, u, p = system.machine(s), system.held(s), integrator.begin(t, dt, substeps)
        while p.gone < dt:
            y, q = integrator.attempt(system, t, x, u, dt, p)
            if q.gone > p.gone:
                now = t + p.gone
                m = hear(watch, m, system, system.between(s, x, now), now, q.gone - p.gone)
            x, p = y, q
        return x, m

    def whole_periods(system, integrator, watch, m, s, t, dt, substeps):  # type: ignore[no-untyped-def]
        m = hear(watch, m, system, s, t, dt)
        return integrator.advance(system, t, system.machine(s), system.held(s), dt, substeps), m

    kind = type(study.integrator)
    if has_single_steps(study):
        return single_step
    if not is_silent(study.watch.steps):
        if hasattr(kind, "substep"):
            return equal_steps
        chooses = all(hasattr(kind, name) for name in ("begin", "attempt"))
        return chosen_steps if chooses else whole_periods
    return unheard
