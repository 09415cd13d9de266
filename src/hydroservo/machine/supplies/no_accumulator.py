"""Nothing that stores oil under pressure."""

from typing import NamedTuple

from hydroservo.core.roles import Accumulator, role


@role(Accumulator)
class NoAccumulator(NamedTuple):
    """No accumulator: its compliance is 0.

    Source: a definition.
    Fails never.
    """

    def compliance(self, pressure: float) -> float:
        return 0.0
