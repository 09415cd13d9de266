"""Blocks asked from outside of a run: the rates of a machine, and a demand, at many instants at once."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block, values
from hydroservo.cosimulation import is_foreign
from hydroservo.loop import Loop, MachineState
from hydroservo.monitors.group import Usual
from hydroservo.roles import Reference
from hydroservo.signals import Demand
from hydroservo.states import filled

Numbers = NDArray[np.float64]
Rates = Callable[[Numbers, float, float], Numbers]


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


def machine_rates(loop: Loop, like: MachineState) -> Rates:
    """A function that gives the rates of the machine at some states.

    It takes states of shape (states, numbers), a command [V] and a force on the rod [N], and returns an array
    of the same shape; a row is nan where a block raises an exception.

    Args:
        loop: the loop, wired.
        like: a state of its machine.
    """
    elsewhere: dict[str, Any] = dict.fromkeys({*Loop._fields} - {*MachineState._fields}, Usual())
    machine = MachineRates(
        loop._replace(**elsewhere)
    )  # all loops with this machine have the same machine code
    ask = answering(machine, Moving(like, 0.0, 0.0), like, interpreted=is_foreign(loop))

    def rates(states: Numbers, command: float, force: float) -> Numbers:
        outside = np.broadcast_to((command, force), (len(states), 2))
        return ask(np.concatenate([states, outside], axis=1))

    return rates


def demands(reference: Reference, times: Numbers) -> Numbers:
    """The value of a reference at some instants; nan where it raises an exception."""
    ask = answering(InstantDemand(reference), Instant(0.0), Demand(0.0, 0.0, 0.0))
    return ask(times[:, np.newaxis])[:, 0]


def answering(
    asked: Asked, given: Block, returned: Block, *, interpreted: bool = False
) -> Callable[[Numbers], Numbers]:
    """What answers to rows of numbers: compiled, and with the same bits in plain Python if it must be."""

    def plain(rows: Numbers) -> Numbers:
        return np.array([answer(asked, given, row, len(values(returned))) for row in rows])

    return plain if interpreted else compiled(asked, given, returned, plain)


def compiled(
    asked: Asked, given: Block, returned: Block, plain: Callable[[Numbers], Numbers]
) -> Callable[[Numbers], Numbers]:
    """What answers to rows of numbers in machine code.

    Args:
        asked: the block that answers.
        given: what its ``row`` is given, for its types.
        returned: what that returns.
        plain: answers with the same bits, of a block that cannot be compiled, and to rows of which it raises.
    """
    from hydroservo.engine.native import CompileError, RunError
    from hydroservo.engine.rows import CompiledRows

    try:
        kernel = CompiledRows(asked, given, returned)
    except CompileError:
        return plain

    def answers(rows: Numbers) -> Numbers:
        try:
            return kernel(rows)
        except RunError:
            return plain(rows)

    return answers


def answer(asked: Asked, given: Block, row: Numbers, count: int) -> Numbers:
    """The answer to one row in plain Python."""
    try:
        return np.array(values(asked.row(filled(given, iter(row.tolist())))), dtype=np.float64)
    except (ArithmeticError, ValueError):
        return np.full(count, np.nan)
