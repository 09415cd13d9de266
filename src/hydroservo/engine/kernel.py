"""The loop over samples of one run: one text, interpreted or compiled."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block
from hydroservo.engine import flat
from hydroservo.engine.native import MachineCode, RunError, native
from hydroservo.engine.recipe import Recipe

__all__ = ["CompiledRun", "InterpretedRun", "Study", "Wanted"]

Out = NDArray[np.float64]


class Study(NamedTuple):
    """All that is constant in a run."""

    system: Block
    integrator: Block
    substeps: int
    metrics: Block


class Wanted(NamedTuple):
    """What to record of each state, what to measure it by, and which of its numbers must stay finite."""

    recorded: tuple[str, ...]
    measured: tuple[str | None, ...]
    sample: type
    watched: tuple[str, ...]


class InterpretedRun:
    """A run in plain Python, to step through."""

    def __init__(self, study: Study, wanted: Wanted, state: Block) -> None:
        self.study, self.state, self.sums = study, state, study.metrics.init()
        self.width = len(wanted.recorded)
        record, read = flat.recorder(wanted.recorded), flat.reader(wanted.measured)
        self.kernel = kernel(record, read, wanted.sample, flat.checker(wanted.watched))

    def advance(self, first: int, last: int, dt: float, stride: int, out: Out) -> int:
        """Samples first to last-1; returns last, or the sample in which a watched number was lost.

        Rows of out: the samples that stride divides.
        """
        check_rows(first, last, stride, out, self.width)
        states = (self.state, self.sums)
        try:
            self.state, self.sums, done = self.kernel(
                *self.study, *states, first, last, dt, stride, out.reshape(-1)
            )
        except Exception as error:  # whatever a block stumbles over
            raise RunError(f"{type(error).__name__}: {error}") from error
        return done


class CompiledRun:
    """The same run in machine code, compiled for each new combination of blocks."""

    def __init__(self, study: Study, wanted: Wanted, state: Block, *, strict: bool) -> None:
        sums = study.metrics.init()
        recipe = Recipe("run", (*map(flat.shape, (study, state, sums)), *wanted), strict)
        self.call = native(recipe, lambda: compiled_run(study, wanted, state, sums, strict))
        self.width = len(wanted.recorded)
        self.study, self.shapes = study, (state, sums)  # kept alive: the table of arrays points into it
        self.constants, self.tables = flat.numbers(study), flat.arrays(study)
        self.states, self.running = flat.numbers(state), flat.numbers(sums)

    def advance(self, first: int, last: int, dt: float, stride: int, out: Out) -> int:
        """Samples first to last-1; returns last, or the sample in which a watched number was lost.

        Rows of out: the samples that stride divides.
        """
        check_rows(first, last, stride, out, self.width)
        memory = (self.constants, self.tables, self.states, self.running, out)
        return int(self.call(*memory, first, last, dt, stride))

    @property
    def state(self) -> Block:
        """The state after the last sample."""
        return flat.builder(self.shapes[0])(self.states.tolist(), [])

    @property
    def sums(self) -> Block:
        """The state of the metrics after the last sample."""
        return flat.builder(self.shapes[1])(self.running.tolist(), [])


def check_rows(first: int, last: int, stride: int, out: Out, width: int) -> None:
    """Refuse memory that does not hold what samples first to last-1 write there.

    Raises:
        ValueError: ``out`` has too few rows, or they are not ``width`` contiguous doubles each; or there are
            no such samples.
    """
    if stride < 1 or not 0 <= first <= last:
        raise ValueError(f"there are no samples {first} to {last}, every {stride}")
    rows = -(-last // stride) + (-first // stride)
    if out.ndim != 2 or out.shape[1] != width or out.shape[0] < rows:
        raise ValueError(f"{rows} rows of {width} numbers do not fit into an array of shape {out.shape}")
    if out.dtype != np.float64 or not out.flags.carray:
        raise ValueError("rows go into a contiguous, writeable array of doubles")


def compiled_run(study: Study, wanted: Wanted, state: Block, sums: Block, strict: bool) -> MachineCode:
    from hydroservo.engine.machine_code import DOUBLES, FLOAT, INTEGER, INTEGERS, inlined, machine_code

    build, state_of, sums_of = (inlined(flat.builder(block)) for block in (study, state, sums))
    put_state, put_sums = (inlined(flat.storer(block)) for block in (state, sums))
    record, read = inlined(flat.recorder(wanted.recorded)), inlined(flat.reader(wanted.measured))
    run = inlined(kernel(record, read, wanted.sample, inlined(flat.checker(wanted.watched))))

    def advance(constants, tables, states, running, out, first, last, dt, stride):  # type: ignore[no-untyped-def]
        system, integrator, substeps, metrics = build(constants, tables)
        s, m = state_of(states, tables), sums_of(running, tables)
        s, m, done = run(system, integrator, substeps, metrics, s, m, first, last, dt, stride, out)
        put_state(states, 0, s)
        put_sums(running, 0, m)
        return done

    memory = (DOUBLES, INTEGERS, DOUBLES, DOUBLES, DOUBLES)
    return machine_code(advance, (*memory, INTEGER, INTEGER, FLOAT, INTEGER), strict)


def kernel(
    record: Callable[..., Any], read: Callable[..., Any], sample: type, finite: Callable[..., bool]
) -> Callable[..., tuple[Block, Block, int]]:
    def run(
        system: Block,
        integrator: Block,
        substeps: int,
        metrics: Block,
        s: Block,
        m: Block,
        first: int,
        last: int,
        dt: float,
        stride: int,
        out: Any,
    ) -> tuple[Block, Block, int]:
        """Samples first to last-1, or up to the one in which a number of the state stops being finite.

        Rows of out are the samples that stride divides. Returns the state, the metrics' state, and the
        number of that sample; last if there was none.
        """
        row = 0
        for k in range(first, last):
            t = k * dt
            s = system.sample(s, t, dt)
            m = metrics.step(m, t, sample(*read(s)))
            if k % stride == 0:
                record(out, row, s)
                row += 1
            x = integrator.advance(system, t, system.machine(s), system.held(s), dt, substeps)
            s = system.moved(s, x)
            if not finite(s):
                return s, m, k
        return s, m, last

    return run
