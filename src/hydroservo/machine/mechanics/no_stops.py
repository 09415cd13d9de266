"""A stroke without ends."""

from typing import NamedTuple

from hydroservo.core.roles import EndStops, role


@role(EndStops)
class NoStops(NamedTuple):
    """No force at the ends of the stroke, as in the load-pressure form.

    Source: the machine of doi:10.1007/s42401-021-00087-w has none.
    Fails beyond the ends: the chambers then have less than their dead volume.
    """

    def force(self, position: float, velocity: float, stroke: float) -> float:
        return 0.0
