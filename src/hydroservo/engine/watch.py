"""The monitors of a run as one block, and the text that asks each of them.

Compiled code cannot loop over blocks of several types, so they hang together in pairs, and each kind of
hearing has a function written out for them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from hydroservo.core.block import Block, is_block, leaves
from hydroservo.core.states import filled
from hydroservo.engine.flat import written


class End(NamedTuple):
    """No more monitors."""


class Pair(NamedTuple):
    """A monitor, or its state, and those after it."""

    first: Block
    rest: Block


class Watch(NamedTuple):
    """Monitors, or their states, by what they hear: samples alone, or each of the integrator's steps."""

    samples: Block
    steps: Block

    def init(self) -> "Watch":
        """The states of monitors before a run."""
        return Watch(begun(self.samples), begun(self.steps))


def watch_of(monitors: Mapping[str, Block]) -> Watch:
    """Monitors by name as one block."""
    heard = [[one for one in monitors.values() if at_samples(one) is wanted] for wanted in (True, False)]
    return Watch(*map(paired, heard))


def place(monitors: Mapping[str, Block], name: str) -> str:
    """Where the state of a monitor is in that of the watch, such as ``steps.rest.first``."""
    alike = [other for other, one in monitors.items() if at_samples(one) is at_samples(monitors[name])]
    group = "samples" if at_samples(monitors[name]) else "steps"
    return f"{group}.{'rest.' * alike.index(name)}first"


def spans_of(monitors: Mapping[str, Block]) -> dict[str, slice]:
    """Where the numbers of each monitor's state stand among those of the watch."""
    found, start = {}, 0
    for name in sorted(monitors, key=lambda name: not at_samples(monitors[name])):
        end = start + len(list(leaves(monitors[name].init())))
        found[name] = slice(start, end)
        start = end
    return found


def reader(like: Block) -> Callable[[Sequence[float]], Block]:
    """What makes a state of its numbers, in declared order."""
    if any(is_block(part) for part in like):
        return lambda numbers: filled(like, iter(numbers))
    make: Callable[[Sequence[float]], Block] = type(like)._make
    return make


def at_samples(monitor: Block) -> bool:
    return hasattr(type(monitor), "at_samples")


def paired(blocks: list[Block]) -> Block:
    return Pair(blocks[0], paired(blocks[1:])) if blocks else End()


def unpaired(pairs: Block) -> Iterator[Block]:
    while isinstance(pairs, Pair):
        yield pairs.first
        pairs = pairs.rest


def begun(pairs: Block) -> Block:
    return paired([monitor.init() for monitor in unpaired(pairs)])


def silent(pairs: Block) -> bool:
    """True where there is no monitor."""
    return not isinstance(pairs, Pair)


def listener(pairs: Block) -> Callable[..., Any]:
    """A function ``step(w, m, loop, s, t, dt)`` that asks each monitor in ``w`` for its state after ``m``."""

    def text(part: Block, path: str) -> str:
        if not isinstance(part, Pair):
            return "End()"
        own = f"w.{path}first.step(m.{path}first, loop, s, t, dt)"
        return f"Pair({own}, {text(part.rest, f'{path}rest.')})"

    line = f"def step(w, m, loop, s, t, dt): return {text(pairs, '')}"
    return written(line, {"Pair": Pair, "End": End}, "step")
