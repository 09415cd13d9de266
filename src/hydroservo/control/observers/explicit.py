"""sgn taken as it is."""

from collections.abc import Sequence
from typing import NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, below
from hydroservo.core.roles import Realisation, role
from hydroservo.core.signals import Correction


@role(Realisation)
class Explicit(NamedTuple):
    """The reaching law evaluated at the measured surface (forward Euler).

    d_hat = -k s - D sgn(s) - eps |s|^a sgn(s)

    Source: eq. (14) of doi:10.1007/s42401-021-00087-w.
    Fails as an instantaneous estimate: where D > |d| it switches by +-D for ever, and |s| stays at about
    D dt. Where D < |d|, s rests off 0, and the estimate follows with the bandwidth of k and eps alone.
    """

    def supposes(self, D: float, noise: float, dt: float, unit: str) -> Sequence[Assumption]:
        """What it asks of a switching gain D [unit/s], on a surface that is measured with some noise."""
        meaning = "D h, the band in which it switches, is within the noise"
        return [below("explicit sgn", meaning, D * dt, noise, unit)]

    def first(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        return Correction(s, -k * s - D * ops.sign(s) - eps * ops.signed_power(s, a))

    def second(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction:
        return self.first(s, k, D, eps, a, dt)
