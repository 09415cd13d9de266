from typing import Annotated, NamedTuple

from hydroservo import Field
from hydroservo.core.roles import Controller, role


class State(NamedTuple):
    u: Annotated[float, Field(1, "command")]


@role(Controller)
class Law(NamedTuple):
    """u = k e."""

    gain: Annotated[float, Field("V s/m", "gain", above=0)] = 2.0

    def check(self):
        return None

    def caution(self):
        return ""

    def init(self):
        return State(0.0)

    def step(self, s, y, r, dt):
        return State(self.gain * (r.value - y.velocity))
