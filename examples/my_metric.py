"""A metric in a file of its own: copy it, measure something else, run it.

In Python: ``simulate(loop, metrics=[Tolerance()])``.
From a scenario: ``hydroservo run my_metric.toml --plugin my_metric.py``.
"""

from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.control.loop import Loop, LoopState
from hydroservo.core.roles import Monitor, role


class Times(NamedTuple):
    """What it gathers."""

    outside: Annotated[float, Field("s", "time out of tolerance so far")]
    whole: Annotated[float, Field("s", "time so far")]


class Share(NamedTuple):
    """What it comes to."""

    out_of_tolerance: Annotated[
        float, Field("", "share of the time out of tolerance", smaller_is_better=True)
    ]


@role(Monitor)
class Tolerance(NamedTuple):
    """The share of the time in which the velocity is farther from its demand than a tolerance."""

    tolerance: Annotated[float, Field("m/s", "velocity error that is tolerated", "example", above=0)] = 1e-3

    def init(self) -> Times:
        return Times(0.0, 0.0)

    def step(self, m: Times, loop: Loop, s: LoopState, t: float, dt: float) -> Times:
        error = ops.absolute(s.reference.value - s.plant.velocity)
        return Times(m.outside + ops.where(error > self.tolerance, dt, 0.0), m.whole + dt)

    def values(self, m: Times) -> Share:
        return Share(m.outside / m.whole if m.whole > 0.0 else 0.0)
