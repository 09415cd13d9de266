"""Blocks asked from outside of a run: the rates of a machine, and a demand, at many instants at once."""

from collections.abc import Callable, Sequence
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

Numbers = NDArray[np.float64]
Which = NDArray[np.intp]
Answers = Callable[[Numbers, Which], Numbers]
Rates = Callable[[Numbers, Numbers, Which], Numbers]
FIRST = np.zeros(1, dtype=np.intp)  # of the blocks that answer


class Asked(Protocol):
    """A block that answers."""

    def row(self, given: Any) -> Block: ...


class Moving(NamedTuple):
    """A machine under a command [V] and a force on its rod [N]."""

    state: MachineState
    command: float
    force: float


class MachineRates(NamedTuple):
    """A loop that is asked for the rates of its machine."""

    loop: Loop

    def row(self, given: Moving) -> MachineState:
        return self.loop.rates(given.state, given.command, given.force)


class Instant(NamedTuple):
    """At which a reference is asked."""

    time: float


class InstantDemand(NamedTuple):
    """A reference that is asked for its demand."""

    reference: Reference

    def row(self, given: Instant) -> Demand:
        return self.reference.at(given.time)


def machine_rates(loops: Sequence[Loop], like: MachineState) -> Rates:
    """A function that gives the rates of machines at some states.

    It takes states of shape (machines, states, numbers), a command [V] and a force on the rod [N] for each
    machine, and which machines these are; it returns an array like the states. A row is nan where a block
    raises an exception.

    Args:
        loops: wired, alike but for their floats.
        like: a state of their machines.
    """
    elsewhere: dict[str, Any] = dict.fromkeys({*Loop._fields} - {*MachineState._fields}, Usual())
    # all loops with this machine have the same machine code
    machines = [MachineRates(loop._replace(**elsewhere)) for loop in loops]
    ask = answering(machines, Moving(like, 0.0, 0.0), like, interpreted=has_fmu(loops[0]))

    def rates(states: Numbers, outside: Numbers, which: Which) -> Numbers:
        same = np.broadcast_to(outside[:, np.newaxis], (*states.shape[:2], 2))
        return ask(np.concatenate([states, same], axis=2), which)

    return rates


def demands(reference: Reference, times: Numbers) -> Numbers:
    """The value of a reference at some instants; nan where it raises an exception."""
    ask = answering([InstantDemand(reference)], Instant(0.0), Demand(0.0, 0.0, 0.0))
    return ask(times[np.newaxis, :, np.newaxis], FIRST)[0, :, 0]


def answering(asked: Sequence[Asked], given: Block, returned: Block, *, interpreted: bool = False) -> Answers:
    """What answers to rows of numbers: compiled, and with the same bits in plain Python if it must be."""

    def plain(rows: Numbers, which: Which) -> Numbers:
        count = len(values(returned))
        pairs = zip(which, rows, strict=True)
        return np.array([[answer(asked[i], given, row, count) for row in part] for i, part in pairs])

    return plain if interpreted else compiled(asked, given, returned, plain)


def compiled(asked: Sequence[Asked], given: Block, returned: Block, plain: Answers) -> Answers:
    """What answers to rows of numbers in machine code.

    Args:
        asked: the blocks that answer, alike but for their floats.
        given: what their ``row`` is given, for its types.
        returned: what that returns.
        plain: answers with the same bits, of blocks that cannot be compiled, and to rows of which one raises.
    """
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


def answer(asked: Asked, given: Block, row: Numbers, count: int) -> Numbers:
    """The answer to one row in plain Python."""
    try:
        return np.array(values(asked.row(filled(given, iter(row.tolist())))), dtype=np.float64)
    except (ArithmeticError, ValueError):
        return np.full(count, np.nan)
