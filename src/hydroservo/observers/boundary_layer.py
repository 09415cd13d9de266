"""sgn smoothed over a boundary layer."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.signals import Correction

__all__ = ["BoundaryLayer"]

CHOSEN = "chosen for the reproduction; the paper gives none"


class BoundaryLayer(NamedTuple):
    """The reaching law with tanh(s/phi) in place of sgn(s).

    d_hat = -k s - D tanh(s/phi) - eps |s|^a sgn(s)

    Source: Slotine and Li, Applied Nonlinear Control, 1991, sec. 7.2 (there with a saturation).
    Fails where phi is small against D dt (it chatters as sgn does) or large against the wanted
    accuracy (the estimate lags, with a bandwidth of k + D/phi).
    """

    velocity_thickness: Annotated[float, Field("m/s", "boundary layer phi_1 on s1", CHOSEN, above=0)] = 1e-3
    force_thickness: Annotated[float, Field("N", "boundary layer phi_2 on s2", CHOSEN, above=0)] = 1e-3

    def velocity(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        return self.smooth(s / self.velocity_thickness, s, k, D, eps, a)

    def force(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        return self.smooth(s / self.force_thickness, s, k, D, eps, a)

    def smooth(self, ratio: float, s: float, k: float, D: float, eps: float, a: float) -> Correction:
        return Correction(s, -k * s - D * ops.tanh(ratio) - eps * ops.signed_power(s, a))
