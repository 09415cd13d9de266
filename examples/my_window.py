"""A law that remembers a window of samples, in a vector: copy it, change what is kept, run it.

In Python: ``hs.replace(loop, {"controller": MeanErrorP(3.0)})``.
From a scenario: ``type = "MeanErrorP"`` in ``[controller]``, and ``--plugin my_window.py``.
"""

from typing import Annotated, NamedTuple

from hydroservo import Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.vectors import vector

Errors = vector("Errors", 5, Field("m/s", "velocity error, by age"))


class MeanErrorPState(NamedTuple):
    """The last command and the last errors, the newest first."""

    u: Annotated[float, Field("V", "command")]
    errors: Errors


@role(Controller)
class MeanErrorP(NamedTuple):
    """u = k_p times the mean of the last five errors: noise counts for less, and the command comes later.

    Source: an example.
    Fails where two samples of delay are much beside the machine's own.
    """

    proportional_gain: Annotated[float, Field("V s/m", "gain k_p", "example", at_least=0)] = 3.0

    def init(self) -> MeanErrorPState:
        return MeanErrorPState(0.0, Errors(0.0, 0.0, 0.0, 0.0, 0.0))

    def step(self, s: MeanErrorPState, y: Measurement, r: Demand, dt: float) -> MeanErrorPState:
        errors = s.errors.shifted(r.value - y.velocity)
        return MeanErrorPState(0.2 * self.proportional_gain * errors.total(), errors)
