"""The monitors of a run as one block, and the text that asks each of them.

Compiled code cannot loop over blocks of several types, so they hang together in pairs, and each kind of
hearing has a function written out for them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from hydroservo.core.block import Block, is_block, leaves
from hydroservo.core.states import filled
from hydroservo.engine.flat import text_function


class End(NamedTuple):
    """No more monitors."""


class MonitorPair(NamedTuple):
    """A monitor, or its state, and those after it."""

    first: Block
    rest: Block


class MonitorGroups(NamedTuple):
    """Monitors, or their states, by what they hear: samples alone, or each of the integrator's steps."""

    samples: Block
    steps: Block

    def init(self) -> "MonitorGroups":
        """The states of monitors before a run."""
        return MonitorGroups(begun(self.samples), begun(self.steps))


def monitor_groups(monitors: Mapping[str, Block]) -> MonitorGroups:
    stepped = [monitor for monitor in monitors.values() if not is_sampled(monitor)]
    return MonitorGroups(as_pairs(list(filter(is_sampled, monitors.values()))), as_pairs(stepped))


def monitor_place(monitors: Mapping[str, Block], name: str) -> str:
    """Where the state of a monitor is in that of the watch, such as ``steps.rest.first``."""
    sampled = is_sampled(monitors[name])
    alike = [other for other, monitor in monitors.items() if is_sampled(monitor) is sampled]
    return f"{'samples' if sampled else 'steps'}.{'rest.' * alike.index(name)}first"


def spans_of(monitors: Mapping[str, Block]) -> dict[str, slice]:
    """Where the numbers of each monitor's state stand among those of the watch."""
    spans, start = {}, 0
    for name in sorted(monitors, key=lambda name: not is_sampled(monitors[name])):
        spans[name] = slice(start, start := start + len(list(leaves(monitors[name].init()))))
    return spans


def state_reader(like: Block) -> Callable[[Sequence[float]], Block]:
    """What makes a state of its numbers, in declared order."""
    if any(is_block(part) for part in like):
        return lambda numbers: filled(like, iter(numbers))
    make: Callable[[Sequence[float]], Block] = type(like)._make
    return make


def is_sampled(monitor: Block) -> bool:
    return hasattr(type(monitor), "at_samples")


def as_pairs(blocks: list[Block]) -> Block:
    return MonitorPair(blocks[0], as_pairs(blocks[1:])) if blocks else End()


def from_pairs(pairs: Block) -> Iterator[Block]:
    while isinstance(pairs, MonitorPair):
        yield pairs.first
        pairs = pairs.rest


def begun(pairs: Block) -> Block:
    return as_pairs([monitor.init() for monitor in from_pairs(pairs)])


def is_silent(pairs: Block) -> bool:
    """True where there is no monitor."""
    return not isinstance(pairs, MonitorPair)


def listener(pairs: Block) -> Callable[..., Any]:
    """A function ``step(w, m, loop, s, t, dt)`` that asks each monitor in ``w`` for its state after ``m``."""

    def text(part: Block, path: str) -> str:
        if not isinstance(part, MonitorPair):
            return "End()"
        own = f"w.{path}first.step(m.{path}first, loop, s, t, dt)"
        return f"Pair({own}, {text(part.rest, f'{path}rest.')})"

    line = f"def step(w, m, loop, s, t, dt): return {text(pairs, '')}"
    return text_function(line, {"Pair": MonitorPair, "End": End}, "step")
