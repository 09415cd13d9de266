"""The metrics of many runs, from what their monitors gathered."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from hydroservo.core.block import Block
from hydroservo.engine.watch import spans_of, state_reader
from hydroservo.runs.rows import FIRST, Numbers, compiled

MANY = 10_000  # runs: asking the monitors of fewer in plain Python takes no longer than compiling

Finish = Callable[[Numbers], Numbers]


class MonitorMetrics(NamedTuple):
    """A monitor that is asked for its metrics."""

    monitor: Any

    def row(self, gathered: Block) -> Block:
        found: Block = self.monitor.values(gathered)
        return found


def finisher(monitors: Mapping[str, Block], runs: int) -> Finish:
    """What makes the metrics, shape (metrics, runs), of the watch's numbers, shape (numbers, runs).

    Args:
        monitors: by name.
        runs: how many there are in all; machine code asks the monitors of many, with the same bits.
    """
    spans = spans_of(monitors)
    make = quick if runs >= MANY else plain
    parts = [(spans[name], make(monitor)) for name, monitor in monitors.items()]

    def finish(sums: Numbers) -> Numbers:
        return np.concatenate([part(sums[span].T) for span, part in parts], axis=1).T

    return finish


def plain(monitor: Any) -> Finish:
    """What asks a monitor for its metrics, a row for each of the states that it is given."""
    read = state_reader(monitor.init())

    def ask(rows: Numbers) -> Numbers:
        return np.array([monitor.values(read(row)) for row in rows.tolist()], dtype=np.float64)

    return ask


def quick(monitor: Any) -> Finish:
    """The same in machine code, where it can be compiled and does not raise."""
    state, slow = monitor.init(), plain(monitor)
    asked, returned = [MonitorMetrics(monitor)], monitor.values(state)
    ask = compiled(asked, state, returned, lambda rows, _: slow(rows[0])[np.newaxis])
    return lambda rows: ask(rows[np.newaxis], FIRST)[0]
