"""What the command does."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, at_samples, role


class CommandEffortState(NamedTuple):
    """Sums over the samples so far."""

    samples: float
    squares: float
    largest: float
    variation: float
    last: float


class CommandEffortValues(NamedTuple):
    """What it comes to."""

    control_rms: Annotated[float, Field("V", "rms of the command", smaller_is_better=True)]
    control_total_variation: Annotated[
        float, Field("V", "sum of the command's changes", smaller_is_better=True)
    ]
    control_max: Annotated[float, Field("V", "largest command", smaller_is_better=True)]


@role(Monitor)
@at_samples
class CommandEffort(NamedTuple):
    """The size and the liveliness of the command u, over the samples.

    rms = sqrt(mean of u^2), total variation = sum of |u_k - u_(k-1)|, and the largest |u|.

    Source: Skogestad, Journal of Process Control 13(4), 2003, doi:10.1016/S0959-1524(02)00062-8, sec. 3
    (the total variation).
    Fails to compare laws of different sample periods by the total variation of their noise.
    """

    def init(self) -> CommandEffortState:
        return CommandEffortState(0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, m: CommandEffortState, loop: Block, s: Block, t: float, dt: float) -> CommandEffortState:
        u = s.controller.u
        change = ops.where(m.samples > 0.0, ops.absolute(u - m.last), 0.0)
        return CommandEffortState(
            samples=m.samples + 1.0,
            squares=m.squares + u * u,
            largest=ops.maximum(ops.absolute(u), m.largest),
            variation=m.variation + change,
            last=u,
        )

    def values(self, m: CommandEffortState) -> CommandEffortValues:
        rms = math.sqrt(m.squares / m.samples) if m.samples > 0.0 else math.nan
        return CommandEffortValues(rms, m.variation, m.largest)
