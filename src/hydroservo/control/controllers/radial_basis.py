"""A radial basis function network of the velocity."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Basis, role
from hydroservo.core.vectors import vector

Weights = vector("Weights", 7, Field("m/s^2", "weight of function"))


class Bells(NamedTuple):
    """The functions and their slopes [s/m] at a velocity."""

    values: Block
    slopes: Block


@role(Basis)
class RadialBasis(NamedTuple):
    """An acceleration that is an unknown function of the velocity, such as friction's: seven Gaussian bells.

    Their centres lie evenly from -``span`` to ``span``, each bell as wide as they are apart::

        a(x1) = sum w_i phi_i,   phi_i = exp(-(x1 - c_i)^2/(2 (span/3)^2))

    Weights begin at 0, move by s^2 phi_i times what drives them, s the ``largest`` weight, are clipped to
    +-s, and are forgotten at a rate (sigma modification).

    Source: Sanner, Slotine, IEEE Trans. Neural Networks 3(6), 1992 (unverified); the forgetting: Ioannou,
    Kokotovic, Automatica 20(5), 1984 (unverified). Seven bells and their width are chosen here.
    Fails for what depends on time, such as most loads: it then follows as one more integral does, and what it
    learns is wrong the next time; so does quick adaptation, which follows what it could learn. Beyond the
    span it falls to 0 within three of a bell's widths, centres where the velocity never is learn nothing, and
    what is steeper than a bell, as friction at reversal is, it rounds.
    """

    span: Annotated[float, Field("m/s", "velocity of the outermost centres", above=0)]
    largest: Annotated[float, Field("m/s^2", "largest weight", above=0)]
    forgetting: Annotated[float, Field("1/s", "rate at which weights fall to 0", "0: never", at_least=0)] = (
        0.0
    )

    def init(self) -> Block:
        return Weights(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def at(self, velocity: float) -> Bells:
        """phi and its slope; those at rest where the velocity is not a number."""
        z = ops.where(ops.isnan(velocity), 0.0, velocity) * (3.0 / self.span)
        distances = Weights(z + 3.0, z + 2.0, z + 1.0, z, z - 1.0, z - 2.0, z - 3.0)
        values = Weights(
            self.bell(z + 3.0),
            self.bell(z + 2.0),
            self.bell(z + 1.0),
            self.bell(z),
            self.bell(z - 1.0),
            self.bell(z - 2.0),
            self.bell(z - 3.0),
        )
        return Bells(values, values.times(distances).scaled(-3.0 / self.span))

    def bell(self, z: float) -> float:
        return ops.power(math.e, -0.5 * z * z)

    def value(self, s: Block, at: Bells) -> float:
        """a(x1) [m/s^2]."""
        found: float = at.values.dot(s)
        return found

    def slope(self, s: Block, at: Bells) -> float:
        """da/dx1 [1/s]."""
        found: float = at.slopes.dot(s)
        return found

    def squared(self, at: Bells) -> float:
        """Sum of the squares of what each weight can do [m^2/s^4]."""
        found: float = self.largest * self.largest * at.values.dot(at.values)
        return found

    def most(self, at: Bells) -> float:
        """What all of them together can do [m/s^2]."""
        found: float = self.largest * at.values.total()
        return found

    def adapted(self, s: Block, at: Bells, drive: float, dt: float) -> Block:
        """The weights after a sample; a drive that is not a number moves nothing."""
        step = ops.where(ops.isnan(drive), 0.0, self.largest * self.largest * drive)
        kept = 1.0 / (1.0 + dt * self.forgetting)
        ends = s.filled(self.largest)
        return s.plus(at.values.scaled(step)).scaled(kept).clipped(ends.scaled(-1.0), ends)
