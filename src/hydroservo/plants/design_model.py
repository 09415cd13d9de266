"""What a controller believes about the machine: the nominal model of eqs. (6)-(7)."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.plants.load_pressure import LoadPressurePlant
from hydroservo.sources import TSMC_EHA_2021
from hydroservo.supplies.ideal import IdealSupply
from hydroservo.valves.orifice import Orifice

__all__ = ["DesignModel"]


class DesignModel(NamedTuple):
    """The machine in strict-feedback form with nominal parameters and a valve without lag.

    With x1 the velocity and x2 = A_p p_L::

        dx1/dt = f1(x1) + g1 x2 + d_L1          f1 = -b x1/m,  g1 = 1/m
        dx2/dt = f2(x1, x2) + g2(x2, u) u + d_L2

    d_L1 and d_L2 are the lumped uncertainty: whatever the real machine does besides. The argument of
    g2's square root is kept at least ``least_drop``, and g2 takes the sign of a command that is known.

    Source: eqs. (6)-(7) of doi:10.1007/s42401-021-00087-w, d_L2 read as Delta f2 + Delta g2 u.
    Fails where the valve's lag matters: that difference is part of d_L2.
    """

    plant: LoadPressurePlant = LoadPressurePlant()
    orifice: Orifice = Orifice()
    supply: IdealSupply = IdealSupply()
    valve_gain: Annotated[float, Field("m/V", "servo valve gain K_sv", TSMC_EHA_2021, above=0)] = 5e-4
    least_drop: Annotated[
        float, Field("Pa", "least pressure drop assumed in g2", "numerical floor", above=0)
    ] = 1e3

    def f1(self, velocity: float) -> float:
        return self.f1_slope() * velocity

    def f1_slope(self) -> float:
        return -self.plant.damping / self.plant.mass

    def g1(self) -> float:
        return 1.0 / self.plant.mass

    def f2(self, velocity: float, load_force: float) -> float:
        return self.plant.free_force_rate(velocity, load_force)

    def g2(self, load_force: float, command: float) -> float:
        drop = self.supply.drop() - ops.sign(command) * load_force * (1.0 / self.plant.piston_area)
        per_opening = self.orifice.flow_per_opening(ops.maximum(drop, self.least_drop))
        return self.plant.flow_gain() * per_opening * self.valve_gain
