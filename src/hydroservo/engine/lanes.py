"""Many runs side by side: states in a structure of arrays, one lane a run.

A buffer holds LANES numbers for each field of a state, so that a loop over lanes loads, computes and
stores with vector instructions. The functions that read and write a state there are written as text for
each state type; all else is the text that single runs use, so that a lane gives a single run's bits.
"""

from collections.abc import Callable, Sequence
from threading import Lock
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hydroservo.block import Block, is_block, leaves
from hydroservo.engine.jit import INLINE, compiled
from hydroservo.engine.tree import reader, written

__all__ = ["LANES", "filled", "lane_kernel"]

LANES = 32  # four vectors of eight: enough to hide latencies, few enough for the states to stay in cache
KERNELS: dict[Any, Callable[..., None]] = {}
LOCK = Lock()  # two threads that ask for one kernel get one, compiled once


def filled(block: Block) -> NDArray[np.float64]:
    """A buffer that holds a state in every lane."""
    return np.repeat(np.array([value for _, value in leaves(block)], dtype=np.float64), LANES)


def lane_kernel(
    system: Block, metrics: Block, sample: type, varied: Sequence[str], measured: Sequence[str | None]
) -> Callable[..., None]:
    """The kernel of LANES runs that differ in the varied paths of the system, for compiled code."""
    key = (structure(system), structure(metrics), sample, tuple(varied), tuple(measured))
    with LOCK:
        if key not in KERNELS:
            KERNELS[key] = built_kernel(system, metrics, sample, tuple(varied), measured)
        return KERNELS[key]


def structure(block: Block) -> tuple[Any, ...]:
    """The classes of a block and of all that is in it."""
    return (type(block), *(structure(value) if is_block(value) else type(value) for value in block))


def built_kernel(
    system: Block, metrics: Block, sample: type, varied: tuple[str, ...], measured: Sequence[str | None]
) -> Callable[..., None]:
    s, m = system.init(), metrics.init()
    lane_of = varier(system, varied)
    state, put_state, put_machine = loader(s), storer(s), storer(system.machine(s))
    sums, put_sums, choose = loader(m), storer(m), chooser(m)
    read = inlined(reader(measured))

    @compiled
    def run(
        system: Block,
        integrator: Block,
        metrics: Block,
        parameters: NDArray[np.float64],
        states: NDArray[np.float64],
        running: NDArray[np.float64],
        alive: NDArray[np.float64],
        first: int,
        last: int,
        dt: float,
    ) -> None:
        """Samples first to last-1 in every lane, from the initial state if first is 0.

        A lane whose state is no longer finite is not alive: it runs on, and its metrics stay.
        """
        h = dt / integrator.substeps
        if first == 0:
            for lane in range(LANES):
                put_state(states, lane, lane_of(system, parameters, lane).init())
        for k in range(first, last):
            t = k * dt
            for lane in range(LANES):
                own = lane_of(system, parameters, lane)
                after = own.sample(state(states, lane), t, dt)
                before = sums(running, lane)
                added = metrics.step(before, t, sample(*read(after)))
                put_sums(running, lane, choose(alive[lane] > 0.0, added, before))
                put_state(states, lane, after)
            for i in range(integrator.substeps):
                for lane in range(LANES):
                    own = lane_of(system, parameters, lane)
                    held = state(states, lane)
                    x = integrator.substep(own, t + i * h, own.machine(held), own.command(held), h)
                    put_machine(states, lane, x)
            for lane in range(LANES):
                x = system.machine(state(states, lane))
                alive[lane] = alive[lane] if system.finite(x) else 0.0

    return run


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    dispatcher: Callable[..., Any] = njit(**INLINE)(function)
    return dispatcher


def loader(block: Block) -> Callable[..., Any]:
    """A function ``load(buffer, lane)`` that returns a lane's state."""
    order = {path: i for i, (path, _) in enumerate(leaves(block))}
    return constructor("load(buffer, lane)", block, lambda path: f"buffer[{order[path] * LANES} + lane]")


def storer(block: Block) -> Callable[..., Any]:
    """A function ``store(buffer, lane, s)`` that writes a lane's state, or the first part of one."""
    lines = [f"    buffer[{i * LANES} + lane] = s.{path}" for i, (path, _) in enumerate(leaves(block))]
    return inlined(
        written("\n".join(["def store(buffer, lane, s):", *lines, "    return None"]), {}, "store")
    )


def varier(block: Block, varied: tuple[str, ...]) -> Callable[..., Any]:
    """A function ``vary(block, parameters, lane)`` that returns the block with a lane's own parameters."""

    def text(path: str) -> str:
        return f"parameters[{varied.index(path) * LANES} + lane]" if path in varied else f"block.{path}"

    return constructor("vary(block, parameters, lane)", block, text)


def chooser(block: Block) -> Callable[..., Any]:
    """A function ``choose(condition, a, b)`` that returns a or b, number by number."""
    return constructor(
        "choose(condition, a, b)", block, lambda path: f"(a.{path} if condition else b.{path})"
    )


def constructor(signature: str, block: Block, text: Callable[[str], str]) -> Callable[..., Any]:
    """A function that makes a block of this structure from the text of each of its numbers."""
    namespace: dict[str, Any] = {}

    def call(part: Block, prefix: str) -> str:
        name = f"T{len(namespace)}"
        namespace[name] = type(part)
        arguments = (
            call(value, f"{prefix}{field}.") if is_block(value) else text(f"{prefix}{field}")
            for field, value in zip(part._fields, part, strict=True)
        )
        return f"{name}({', '.join(arguments)})"

    body = call(block, "")
    return inlined(written(f"def {signature}: return {body}", namespace, signature.partition("(")[0]))
