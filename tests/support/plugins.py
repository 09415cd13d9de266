"""Texts of plug-ins, as users write them in files of their own."""

LAW = '''\
from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.control.observers import Implicit
from hydroservo.core.roles import Controller, Observer, role


class State(NamedTuple):
    u: Annotated[float, Field("V", "command")]


@role(Controller)
class Law(NamedTuple):
    """u = k e."""

    gain: Annotated[float, Field("V s/m", "gain k", above=0)] = 2.0

    def init(self):
        return State(0.0)

    def step(self, s, y, r, dt):
        return State(self.gain * (r.value - y.velocity))
'''
MECHANISM = '''\
from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.core.roles import Mechanism, role


@role(Mechanism)
class OntoBlank(NamedTuple):
    """A ram that meets a blank: k max(x - x_c, 0)."""

    mass: Annotated[float, Field("kg", "ram", "chosen", above=0)] = 60.0
    contact: Annotated[float, Field("m", "where it meets the blank", "chosen")] = 0.1
    stiffness: Annotated[float, Field("N/m", "of the blank", "chosen", at_least=0)] = 1e6

    def inertia(self, position: float) -> float:
        return self.mass

    def resistance(self, position: float, velocity: float) -> float:
        return self.stiffness * ops.maximum(position - self.contact, 0.0)
'''
METRIC = '''\
from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.core.roles import Monitor, role


class Crossings(NamedTuple):
    count: Annotated[float, Field("", "zero crossings so far")]
    last: float


class Counted(NamedTuple):
    zero_crossings: Annotated[float, Field("", "zero crossings of the error", smaller_is_better=True)]


@role(Monitor)
class ZeroCrossings(NamedTuple):
    """How often the velocity error changes its sign."""

    def init(self):
        return Crossings(0.0, 0.0)

    def step(self, m, loop, s, t, dt):
        error = s.reference.value - s.plant.velocity
        return Crossings(m.count + ops.where(error * m.last < 0.0, 1.0, 0.0), error)

    def values(self, m):
        return Counted(m.count)
'''
