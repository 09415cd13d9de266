"""What limits a loop's command, whatever law gives it."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.controllers import DAC, Delay, Dither, RateLimit
from hydroservo.control.loop import Loop
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.signals import Demand, Measurement


class CommandLimits(NamedTuple):
    """What limits a command."""

    limit: float  # its largest size [V]
    rate: float  # its largest rate [V/s]; inf for none
    late: int  # samples from the one at which a law knows something to the first command that can tell
    period: float  # between samples [s]

    @property
    def rated(self) -> bool:
        """Whether its rate is limited."""
        return math.isfinite(self.rate)


def command_limits(loop: Loop) -> CommandLimits:
    """The limits of a loop's command: those of its converter, its rate and its delay, and of its law.

    Converter, rate limit and delay are the wrappers that lie outside of the law. A law's own limit is its
    ``saturation``; where that has none, the valve's travel is one, beyond which a command does nothing. The
    steps of a converter are left out: so the limits allow more than the loop does.
    """
    law, limit, rate, late = loop.controller, math.inf, math.inf, 0
    while isinstance(law, DAC | Dither | RateLimit | Delay):
        limit = min(limit, law.limit) if isinstance(law, DAC) else limit
        rate = min(rate, law.rate) if isinstance(law, RateLimit) else rate
        late += isinstance(law, Delay)
        law = law.controller
    limit = min(limit, getattr(getattr(law, "saturation", None), "limit", math.inf))
    if not math.isfinite(limit):
        limit = getattr(loop.valve, "max_opening", math.inf) / getattr(loop.valve, "gain", 1.0)
    if not math.isfinite(limit):
        problem = "has no limit of its command: put a DAC around it, or give it a saturation"
        raise ParameterError("controller", type(loop.controller).__name__, problem)
    return CommandLimits(limit, rate, late, loop.simulation.period)


def loosest_limits(limits: Sequence[CommandLimits]) -> CommandLimits:
    """What limits the commands of all of some laws at one sample rate: none of them can give others."""
    size, rate = max(one.limit for one in limits), max(one.rate for one in limits)
    return CommandLimits(size, rate, min(one.late for one in limits), limits[0].period)


class PlaybackState(NamedTuple):
    """The last command, and the number of the next one."""

    u: Annotated[float, Field("V", "command")]
    sample: Annotated[float, Field("", "samples so far")]


class Playback(NamedTuple):
    """u_k as it was recorded.

    Source: a definition.
    Fails to keep a machine anywhere that is not the one for which the commands were found.
    """

    commands: Annotated[NDArray[np.float64], Field("V", "command at each sample, shape (samples,)")]
    first: Annotated[float, Field("V", "command before the first sample")] = 0.0

    def init(self) -> PlaybackState:
        return PlaybackState(self.first, 0.0)

    def step(self, s: PlaybackState, y: Measurement, r: Demand, dt: float) -> PlaybackState:
        return PlaybackState(float(self.commands[int(s.sample)]), s.sample + 1.0)
