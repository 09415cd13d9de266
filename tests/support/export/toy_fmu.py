"""The toy's PI as an FMU: its variables, its equal in Python, and calls of it that must fail."""

from collections.abc import Callable

import pytest
from fmpy.fmi1 import FMICallException

from tests.support.export.fmus import Instance

OK, WARNING, DISCARD, ERROR = range(4)
GAIN, INTEGRAL = "controller.proportional_gain", "controller.integral"
VELOCITY, DEMAND, COMMAND = "measurement.velocity", "demand.value", "controller.u"


class Replica:
    """The toy's PI in Python."""

    def __init__(self, gain: float = 100.0) -> None:
        self.gain, self.integral = gain, 0.0

    def step(self, velocity: float, demand: float) -> tuple[float, float]:
        error = demand - velocity
        self.integral = self.integral + 1e-5 * (10.0 * error)
        unlimited = self.gain * error + self.integral
        return max(-10.0, min(10.0, unlimited)), self.integral


def refused(instance: Instance, call: str, *arguments: object) -> str:
    """The message of a call that must fail."""
    return refusal(instance, lambda: getattr(instance, call)(*arguments))


def refusal(instance: Instance, call: Callable[[], object]) -> str:
    """The message of calls of which the last must fail."""
    return said(instance, call, ERROR, "logStatusError")


def discarded(instance: Instance, call: str, *arguments: object) -> str:
    """The message of a call that must change nothing, and leave the instance as usable as it was."""
    return said(instance, lambda: getattr(instance, call)(*arguments), DISCARD, "logStatusDiscard")


def said(instance: Instance, call: Callable[[], object], status: int, category: str) -> str:
    instance.messages.clear()
    with pytest.raises(FMICallException) as caught:
        call()
    assert caught.value.status == status
    ((found, text),) = instance.messages
    assert found == category
    return text
