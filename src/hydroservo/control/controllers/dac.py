"""A law whose command leaves through a digital-to-analogue converter."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.sources import CHOSEN

FINE = 50  # bits that nothing tells from none


class DACState(NamedTuple):
    """What is put out, and the nested law's state."""

    u: Annotated[float, Field("V", "command")]
    controller: Block


@role(Controller)
class DAC(NamedTuple):
    """The command of a nested law, rounded to the nearest step of a converter.

    u = q code,  q = 2 limit/2^bits,  code = nearest(u_law/q) within -2^(bits-1) and 2^(bits-1) - 1

    The largest command is limit - q, as there is one code less above zero than below. The nested law learns
    what was put out from the measurement's command.

    Source: two's complement coding of a bipolar converter; Widrow and Kollar, Quantization Noise, 2008.
    Fails as all rounding does inside a loop with an integrator: near rest the command may step between two
    codes for ever, a limit cycle.
    """

    controller: Controller
    bits: Annotated[int, Field("", "of the converter", CHOSEN, at_least=1, at_most=32)] = 12
    limit: Annotated[float, Field("V", "the converter's range is +-limit", CHOSEN, above=0)] = 10.0

    def smoothed(self) -> "DAC":
        return self._replace(bits=FINE)

    def init(self) -> DACState:
        return DACState(0.0, self.controller.init())

    def step(self, s: DACState, y: Measurement, r: Demand, dt: float) -> DACState:
        controller = self.controller.step(s.controller, y, r, dt)
        half = float(1 << self.bits) * 0.5
        step = self.limit / half
        within = ops.clip(controller.u, -self.limit, self.limit)
        return DACState(step * ops.minimum(half - 1.0, ops.nearest(within / step)), controller)
