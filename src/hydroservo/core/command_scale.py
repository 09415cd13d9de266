"""What a valve's command is read and written in: volts inside, mA or % of the valve at the door."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from fractions import Fraction
from functools import cache
from typing import Annotated, NamedTuple

from hydroservo.core.field import Field, power_in

DEFINITION = "a definition"
FULL = 10  # V, what the converter puts out at most
VOLT = re.compile(r"(?<![A-Za-z])V(?![A-Za-z])")  # in a unit


class CommandScale(NamedTuple):
    """What 10 V of command stand for at the valve: a current, a share of its full command, or 10 V.

    Every law, limit and result counts in volts; this changes none of them, and says in what a person writes
    and reads them: v = 10 V (c/full scale).

    Source: a definition.
    Fails for a block of one's own that has a number in volts which is not of a command: it is read as one.
    """

    current: Annotated[float, Field("A", "current that 10 V stand for", DEFINITION, at_least=0)] = 0.0
    share: Annotated[float, Field("", "share of the full command", DEFINITION, at_least=0)] = 0.0

    @property
    def unit(self) -> str:
        """The unit of a command: V, mA, A from 1 A on, or %."""
        if self.current:
            return "mA" if self.current < 1.0 else "A"
        return "%" if self.share else "V"

    @property
    def per_volt(self) -> Fraction:
        """How many of them a volt is, exactly as the decimals say."""
        size = {"V": float(FULL), "%": self.share}.get(self.unit, self.current)
        return Fraction(repr(size)) * {"mA": 1000, "%": 100}.get(self.unit, 1) / FULL


VOLTS = CommandScale()
PRESENT: ContextVar[CommandScale | list[CommandScale]] = ContextVar("command scale", default=VOLTS)


def is_volts(block: object) -> bool:
    """Whether a block is the scale of commands that are read and written in volts."""
    return isinstance(block, CommandScale) and block == VOLTS


def command_scale() -> CommandScale:
    """What commands are read and written in at present: volts, unless something around says otherwise."""
    present = PRESENT.get()
    if isinstance(present, CommandScale):
        return present
    return present[0] if len(set(present)) == 1 else VOLTS


@contextmanager
def commands_in(scale: CommandScale | None) -> Iterator[None]:
    """Commands inside are read and written in the unit of a scale.

    Args:
        scale: the scale; None for that of all scenarios that are loaded inside, where they have the same.
    """
    token = PRESENT.set([] if scale is None else scale)
    try:
        yield
    finally:
        PRESENT.reset(token)


def note_command_scale(scale: CommandScale) -> None:
    """Say the scale of a scenario that was loaded, for those who read and write by it."""
    present = PRESENT.get()
    if isinstance(present, list):
        present.append(scale)


def in_command_unit(unit: str) -> tuple[str, float]:
    """A unit with that of commands in place of V, and the factor to it: ("mA/m", 4.0) for "V/m" at 40 mA."""
    return exchanged_volts(unit, command_scale())


@cache
def exchanged_volts(unit: str, scale: CommandScale) -> tuple[str, float]:
    power = power_in(unit, "V")
    if not power or scale.unit == "V":
        return unit, 1.0
    return VOLT.sub(scale.unit, unit), float(scale.per_volt**power)
