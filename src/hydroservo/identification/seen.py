"""A monitor that holds what sensors could see at the last sample."""

from typing import NamedTuple

from hydroservo.block import Block
from hydroservo.roles import at_samples
from hydroservo.signals import MachineOutputs


class Nothing(NamedTuple):
    """No metric."""


@at_samples
class Seen(NamedTuple):
    """The machine's outputs at each sample, for whoever looks at them before the next.

    Source: a definition.
    Fails to be a metric of a run: it keeps nothing but the last sample.
    """

    def init(self) -> MachineOutputs:
        return MachineOutputs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, m: MachineOutputs, loop: Block, s: Block, t: float, dt: float) -> MachineOutputs:
        return loop.seen(s, loop.load.force(t))  # type: ignore[no-any-return]

    def values(self, m: MachineOutputs) -> Nothing:
        return Nothing()
