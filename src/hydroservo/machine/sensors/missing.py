"""Signals that nothing measures: using one is an error, passing it on is not."""

from math import isnan
from typing import Any, NoReturn

from hydroservo.core.block import Block
from hydroservo.core.field import declared_fields
from hydroservo.core.roles import Sensors
from hydroservo.core.signals import Draws, MachineOutputs, Measurement

COMPUTED_FROM = {"hydraulic_force": ("pressure_a", "pressure_b"), "velocity": ("position",)}
MEASURING = {  # types of sensors by the field of RigSensors that holds them
    "position": ("Encoder", "IdealPosition"),
    "pressure_a": ("PressureTransducer",),
    "pressure_b": ("PressureTransducer",),
    "force": ("LoadCell",),
}


class MissingSignalError(Exception):
    """A law computes with a signal that nothing measures; the message is its name and what it means.

    Args:
        name: the field of :class:`~hydroservo.core.signals.Measurement`.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name

    def __str__(self) -> str:
        return f"{self.name} ({declared_fields(Measurement)[self.name].meaning})"


class Unmeasured:
    """A number that is not there: it raises :class:`MissingSignalError` in any calculation or comparison.

    It is no float, since C's functions take a float's value without asking. Whether it is there may be asked
    (``ops.isnan``, ``ops.isfinite``); the answer is that of the nan which stands for it in compiled code.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    def __repr__(self) -> str:
        return f"Unmeasured({self.name!r})"

    def used(self, *_: object) -> NoReturn:
        raise MissingSignalError(self.name)

    def __sub__(self, other: object) -> float:
        return float("nan") if other is self else self.used()

    def __eq__(self, other: object) -> bool:
        return False if other is self else self.used()

    def __ne__(self, other: object) -> bool:
        return True if other is self else self.used()

    __add__ = __radd__ = __rsub__ = __mul__ = __rmul__ = __matmul__ = __rmatmul__ = used
    __truediv__ = __rtruediv__ = __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = used
    __divmod__ = __rdivmod__ = __pow__ = __rpow__ = __neg__ = __pos__ = __abs__ = used
    __bool__ = __float__ = __int__ = __index__ = __complex__ = __round__ = used
    __trunc__ = __floor__ = __ceil__ = __array__ = __format__ = used
    __lt__ = __le__ = __gt__ = __ge__ = used
    __hash__ = object.__hash__


class Lacking:
    """Sensors in plain Python whose missing signals are :class:`Unmeasured`.

    Args:
        sensors: the sensors.
        names: the fields of :class:`~hydroservo.core.signals.Measurement` that they do not measure.
    """

    def __init__(self, sensors: Sensors, names: tuple[str, ...]) -> None:
        self.sensors = sensors
        self.unmeasured: dict[str, Any] = {name: Unmeasured(name) for name in names}

    def init(self) -> Block:
        return self.sensors.init()

    def step(self, s: Block, machine: MachineOutputs, draws: Draws, dt: float) -> Block:
        return self.sensors.step(s, machine, draws, dt)

    def measure(self, s: Block, machine: MachineOutputs, command: float) -> Measurement:
        return self.sensors.measure(s, machine, command)._replace(**self.unmeasured)


def missing_signals(sensors: Sensors) -> tuple[str, ...]:
    """The fields of :class:`~hydroservo.core.signals.Measurement` that sensors say they do not measure."""
    found: tuple[str, ...] = getattr(sensors, "missing", tuple)()
    return found


def sensors_for(sensors: Block, signal: str, path: str = "sensors") -> str:
    """What gives a signal that sensors do not measure: keys of a scenario, each with its types.

    Args:
        sensors: the sensors, or what is around them.
        signal: the field of :class:`~hydroservo.core.signals.Measurement`.
        path: of the sensors.
    """
    if hasattr(sensors, "sensors"):
        return sensors_for(sensors.sensors, signal, f"{path}.sensors")
    held = sensors._asdict()
    keys = [
        f"{path}.{name}.type = {' or '.join(MEASURING[name])}"
        for name in COMPUTED_FROM.get(signal, (signal,))
        if name in held and name in MEASURING and isnan(held[name].init().value)
    ]
    return " and ".join(keys) or "a sensor for it"
