"""Signals that nothing measures: using one is an error, passing it on is not."""

from typing import Any

from hydroservo.block import Block, Sensors
from hydroservo.field import declared_fields
from hydroservo.signals import Draws, MachineOutputs, Measurement

__all__ = ["Lacking", "MissingSignalError", "Unmeasured"]


class MissingSignalError(Exception):
    """A law computes with a signal that nothing measures; the message is what the signal means."""


class Unmeasured(float):
    """A number that is not there: it raises :class:`MissingSignalError` in any calculation or comparison."""

    meaning: str

    def __new__(cls, meaning: str) -> "Unmeasured":
        self = super().__new__(cls, "nan")
        self.meaning = meaning
        return self

    def used(self, *_: object) -> Any:
        raise MissingSignalError(self.meaning)

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = used
    __truediv__ = __rtruediv__ = __pow__ = __rpow__ = used
    __neg__ = __pos__ = __abs__ = __float__ = __bool__ = used
    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = used
    __hash__ = float.__hash__


class Lacking:
    """Sensors in plain Python whose missing signals are :class:`Unmeasured`.

    Args:
        sensors: the sensors.
        names: the fields of :class:`~hydroservo.signals.Measurement` that they do not measure.
    """

    def __init__(self, sensors: Sensors, names: tuple[str, ...]) -> None:
        fields = declared_fields(Measurement)
        self.sensors = sensors
        self.unmeasured = {name: Unmeasured(fields[name].meaning) for name in names}

    def init(self) -> Block:
        return self.sensors.init()

    def step(self, s: Block, machine: MachineOutputs, draws: Draws, dt: float) -> Block:
        return self.sensors.step(s, machine, draws, dt)

    def measure(self, s: Block, machine: MachineOutputs, command: float) -> Measurement:
        return self.sensors.measure(s, machine, command)._replace(**self.unmeasured)
