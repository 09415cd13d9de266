"""A valve of a user's own, so that the plant alone is simulated under a smooth command."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.core.block import Field
from hydroservo.machine.valves import Orifice
from hydroservo.testing.examples import example

__all__ = ["ProgrammedValve", "ProgrammedValveState"]


class ProgrammedValveState(NamedTuple):
    """The valve's own clock."""

    time: Annotated[float, Field("s", "time since the start")]


class ProgrammedValve(NamedTuple):
    """x_v = K_sv u(t) within +-x_max, with u = amplitude sin(2 pi frequency t) and no lag: open loop.

    A controller's command is held for a sample period, and no step could be longer than the accuracy of that
    hold allows; this one is as smooth for an integrator as it is for the peers.

    Source: eq. (1) of doi:10.1007/s42401-021-00087-w, with a command of its own.
    Fails as an actuator: it does not listen to its controller.
    """

    amplitude: Annotated[float, Field("V", "amplitude of the command", "30 mm/s at rest, about")] = 0.029
    frequency: Annotated[float, Field("Hz", "frequency of the command", "that of the paper's demand")] = 0.25
    gain: Annotated[float, Field("m/V", "servo valve gain K_sv", "the paper's", above=0)] = 5e-4
    max_opening: Annotated[float, Field("m", "spool limit x_max", "the paper's", above=0)] = 5e-3
    orifice: Orifice = example(Orifice)

    def init(self) -> ProgrammedValveState:
        return ProgrammedValveState(0.0)

    def deriv(self, s: ProgrammedValveState, u: float) -> ProgrammedValveState:
        return ProgrammedValveState(1.0)

    def opening(self, s: ProgrammedValveState, u: float) -> float:
        command = self.amplitude * ops.sin(2.0 * math.pi * self.frequency * s.time)
        return ops.clip(self.gain * command, -self.max_opening, self.max_opening)
