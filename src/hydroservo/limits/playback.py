"""A law that gives recorded commands, whatever it is told."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Field
from hydroservo.signals import Demand, Measurement


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
