"""The loop over samples: one text, interpreted or compiled."""

from collections.abc import Callable, Sequence
from functools import cache
from threading import Lock
from typing import Any

from hydroservo.block import Block
from hydroservo.engine.jit import compiled
from hydroservo.engine.tree import reader, recorder

__all__ = ["compiled_kernel", "interpreted_kernel"]

Kernel = Callable[..., tuple[Block, Block, bool]]

LOCK = Lock()  # two threads that ask for one kernel get one, compiled once


def interpreted_kernel(sample: type, recorded: Sequence[str], measured: Sequence[str | None]) -> Kernel:
    """The same kernel as plain Python, to step through."""
    return kernel(recorder(recorded), reader(measured), sample)


def compiled_kernel(sample: type, recorded: tuple[str, ...], measured: tuple[str | None, ...]) -> Kernel:
    """The kernel that records and measures these paths, compiled for each new combination of blocks."""
    with LOCK:
        return built_kernel(sample, recorded, measured)


@cache
def built_kernel(sample: type, recorded: tuple[str, ...], measured: tuple[str | None, ...]) -> Kernel:
    return compiled(kernel(compiled(recorder(recorded)), compiled(reader(measured)), sample))


def kernel(record: Callable[..., Any], read: Callable[..., Any], sample: type) -> Kernel:
    def run(
        system: Block,
        integrator: Block,
        metrics: Block,
        s: Block,
        m: Block,
        first: int,
        last: int,
        dt: float,
        stride: int,
        out: Any,
    ) -> tuple[Block, Block, bool]:
        """Samples first to last-1, or until the state stops being finite.

        Rows of out are the samples that stride divides. Returns the state, the metrics' state, and
        whether the state is still finite.
        """
        row = 0
        for k in range(first, last):
            t = k * dt
            s = system.sample(s, t, dt)
            m = metrics.step(m, t, sample(*read(s)))
            if k % stride == 0:
                record(out, row, s)
                row += 1
            x = integrator.advance(system, t, system.machine(s), system.command(s), dt)
            s = system.moved(s, x)
            if not system.finite(x):
                return s, m, False
        return s, m, True

    return run
