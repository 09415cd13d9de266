"""Blocks asked outside of a run, many at once: rates of a machine, demands, and metrics of many runs."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop, MachineState
from hydroservo.control.monitors.group import Usual
from hydroservo.core.block import Block, values
from hydroservo.core.roles import Reference
from hydroservo.core.signals import Demand
from hydroservo.core.states import filled
from hydroservo.cosimulation import has_fmu
from hydroservo.engine.watch import spans_of, state_reader

Numbers = NDArray[np.float64]
Which = NDArray[np.intp]
RowFunction = Callable[[Numbers, Which], Numbers]
Rates = Callable[[Numbers, Numbers, Which], Numbers]
FIRST = np.zeros(1, dtype=np.intp)  # of the blocks that answer


class RowBlock(Protocol):
    """A block that answers."""

    def row(self, given: Any) -> Block: ...


class MovingMachine(NamedTuple):
    """A machine under a command [V] and a force on its rod [N]."""

    state: MachineState
    command: float
    force: float


class MachineRates(NamedTuple):
    """A loop that is asked for the rates of its machine."""

    loop: Loop

    def row(self, given: MovingMachine) -> MachineState:
        return self.loop.rates(given.state, given.command, given.force)


class DemandTime(NamedTuple):
    """At which a reference is asked."""

    time: float


class InstantDemand(NamedTuple):
    """A reference that is asked for its demand."""

    reference: Reference

    def row(self, given: DemandTime) -> Demand:
        return self.reference.at(given.time)


def machine_rates(loops: Sequence[Loop], like: MachineState) -> Rates:
    """A function that gives the rates of machines at some states.

    It takes states of shape (machines, states, numbers), a command [V] and a force on the rod [N] for each
    machine, and which machines these are; it returns an array like the states. A row is nan where a block
    raises an exception.
    """
    elsewhere: dict[str, Any] = dict.fromkeys({*Loop._fields} - {*MachineState._fields}, Usual())
    # all loops with this machine have the same machine code
    machines = [MachineRates(loop._replace(**elsewhere)) for loop in loops]
    ask = row_function(machines, MovingMachine(like, 0.0, 0.0), like, interpreted=has_fmu(loops[0]))

    def rates(states: Numbers, outside: Numbers, which: Which) -> Numbers:
        same = np.broadcast_to(outside[:, np.newaxis], (*states.shape[:2], 2))
        return ask(np.concatenate([states, same], axis=2), which)

    return rates


def demand_values(reference: Reference, times: Numbers) -> Numbers:
    """The value of a reference at some instants; nan where it raises an exception."""
    ask = row_function([InstantDemand(reference)], DemandTime(0.0), Demand(0.0, 0.0, 0.0))
    return ask(times[np.newaxis, :, np.newaxis], FIRST)[0, :, 0]


def row_function(
    asked: Sequence[RowBlock], given: Block, returned: Block, *, interpreted: bool = False
) -> RowFunction:
    """What answers to rows of numbers: compiled, and with the same bits in plain Python if it must be."""

    def plain(rows: Numbers, which: Which) -> Numbers:
        count = len(values(returned))
        pairs = zip(which, rows, strict=True)
        return np.array(
            [[interpreted_answer(asked[i], given, row, count) for row in part] for i, part in pairs]
        )

    return plain if interpreted else compiled_row_function(asked, given, returned, plain)


def compiled_row_function(
    asked: Sequence[RowBlock], given: Block, returned: Block, plain: RowFunction
) -> RowFunction:
    """What answers to rows of numbers in machine code."""
    from hydroservo.engine.native import CompileError, RunError
    from hydroservo.engine.rows import CompiledRows

    try:
        kernel = CompiledRows(asked, given, returned)
    except CompileError:
        return plain

    def answers(rows: Numbers, which: Which) -> Numbers:
        try:
            return kernel(rows, which)
        except RunError:
            if len(which) == 1:
                return plain(rows, which)
        halves = zip(np.array_split(rows, 2), np.array_split(which, 2), strict=True)
        return np.concatenate([answers(*half) for half in halves])

    return answers


def interpreted_answer(asked: RowBlock, given: Block, row: Numbers, count: int) -> Numbers:
    """The answer to one row in plain Python."""
    try:
        return np.array(values(asked.row(filled(given, iter(row.tolist())))), dtype=np.float64)
    except (ArithmeticError, ValueError):
        return np.full(count, np.nan)


MANY = 10_000  # runs: asking the monitors of fewer in plain Python takes no longer than compiling

Finish = Callable[[Numbers], Numbers]


class MonitorMetrics(NamedTuple):
    """A monitor that is asked for its metrics."""

    monitor: Any

    def row(self, gathered: Block) -> Block:
        found: Block = self.monitor.values(gathered)
        return found


def finisher(monitors: Mapping[str, Block], runs: int) -> Finish:
    """What makes the metrics, shape (metrics, runs), of the watch's numbers, shape (numbers, runs)."""
    spans = spans_of(monitors)
    make = compiled_metrics if runs >= MANY else interpreted_metrics
    parts = [(spans[name], make(monitor)) for name, monitor in monitors.items()]

    def finish(sums: Numbers) -> Numbers:
        return np.concatenate([part(sums[span].T) for span, part in parts], axis=1).T

    return finish


def interpreted_metrics(monitor: Any) -> Finish:
    """What asks a monitor for its metrics, a row for each of the states that it is given."""
    read = state_reader(monitor.init())

    def ask(rows: Numbers) -> Numbers:
        return np.array([monitor.values(read(row)) for row in rows.tolist()], dtype=np.float64)

    return ask


def compiled_metrics(monitor: Any) -> Finish:
    """The same in machine code, where it can be compiled and does not raise."""
    state, slow = monitor.init(), interpreted_metrics(monitor)
    asked, returned = [MonitorMetrics(monitor)], monitor.values(state)
    ask = compiled_row_function(asked, state, returned, lambda rows, _: slow(rows[0])[np.newaxis])
    return lambda rows: ask(rows[np.newaxis], FIRST)[0]
