"""sgn smoothed over a boundary layer."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, below
from hydroservo.core.block import Field
from hydroservo.core.roles import Realisation, role
from hydroservo.core.signals import Correction
from hydroservo.core.sources import CHOSEN


@role(Realisation)
class BoundaryLayer(NamedTuple):
    """The reaching law with tanh(s/phi) in place of sgn(s).

    d_hat = -k s - D tanh(s/phi) - eps |s|^a sgn(s)

    Source: Slotine and Li, Applied Nonlinear Control, 1991, sec. 7.2 (there with a saturation).
    Fails where D dt/phi exceeds about 2 (it chatters as sgn does). Well inside the layer, where D > |d|, the
    estimate lags with a bandwidth of about k + D/phi; outside it, with that of k and eps alone.
    """

    velocity_thickness: Annotated[float, Field("m/s", "boundary layer phi_1 on s1", CHOSEN, above=0)] = 1e-3
    force_thickness: Annotated[float, Field("N", "boundary layer phi_2 on s2", CHOSEN, above=0)] = 1e-3

    def supposes(self, D: float, noise: float, dt: float, unit: str) -> Sequence[Assumption]:
        """What it asks of a switching gain D [unit/s], on a surface that is measured with some noise."""
        thickness = self.velocity_thickness if unit == "m/s" else self.force_thickness
        return [
            below("boundary layer", "D h is below twice the layer's thickness", D * dt, 2.0 * thickness, unit)
        ]

    def first(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        return self.smooth(s * (1.0 / self.velocity_thickness), s, k, D, eps, a)

    def second(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        return self.smooth(s * (1.0 / self.force_thickness), s, k, D, eps, a)

    def smooth(self, ratio: float, s: float, k: float, D: float, eps: float, a: float) -> Correction:
        return Correction(s, -k * s - D * ops.tanh(ratio) - eps * ops.signed_power(s, a))
