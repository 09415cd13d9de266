"""What a controller believes about the machine: the nominal model of eqs. (6)-(7)."""

from typing import Annotated, NamedTuple, cast

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Model, role
from hydroservo.machine.plants.load_pressure import LoadPressurePlant
from hydroservo.machine.supplies.ideal import IdealSupply
from hydroservo.machine.valves.orifice import Orifice


class NominalMotion(NamedTuple):
    """How the nominal model moves: where it is after some time, or its rates."""

    velocity: Annotated[float, Field("m/s", "velocity x1")]
    hydraulic_force: Annotated[float, Field("N", "hydraulic force x2")]
    travel: Annotated[float, Field("m", "way gone since the start")]


@role(Model)
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

    plant: LoadPressurePlant
    orifice: Orifice
    supply: IdealSupply
    valve_gain: Annotated[float, Field("m/V", "servo valve gain K_sv", above=0)]
    least_drop: Annotated[
        float, Field("Pa", "least pressure drop assumed in g2", "numerical floor", above=0)
    ] = 1e3

    def f1(self, velocity: float) -> float:
        return self.f1_slope() * velocity

    def f1_slope(self) -> float:
        return -self.plant.damping / self.plant.mass

    def g1(self) -> float:
        return 1.0 / self.plant.mass

    def f2(self, velocity: float, hydraulic_force: float) -> float:
        return self.plant.free_force_rate(velocity, hydraulic_force)

    def g2(self, hydraulic_force: float, command: float) -> float:
        drop = self.supply.drop() - ops.sign(command) * hydraulic_force * (1.0 / self.plant.piston_area)
        per_opening = self.orifice.flow_per_opening(ops.maximum(drop, self.least_drop))
        return self.plant.flow_gain() * per_opening * self.valve_gain

    def ahead(
        self, velocity: float, hydraulic_force: float, u: float, d1: float, d2: float, dt: float
    ) -> NominalMotion:
        """Where it is after ``dt`` [s] under a held command and disturbances (classical Runge-Kutta)."""
        drive = d2 + self.g2(hydraulic_force, u) * u
        half, sixth = 0.5 * dt, dt / 6.0
        k1 = self.rates(velocity, hydraulic_force, d1, drive)
        k2 = self.rates(velocity + half * k1.velocity, hydraulic_force + half * k1.hydraulic_force, d1, drive)
        k3 = self.rates(velocity + half * k2.velocity, hydraulic_force + half * k2.hydraulic_force, d1, drive)
        k4 = self.rates(velocity + dt * k3.velocity, hydraulic_force + dt * k3.hydraulic_force, d1, drive)
        return NominalMotion(
            velocity + sixth * (k1.velocity + 2.0 * (k2.velocity + k3.velocity) + k4.velocity),
            hydraulic_force
            + sixth
            * (k1.hydraulic_force + 2.0 * (k2.hydraulic_force + k3.hydraulic_force) + k4.hydraulic_force),
            sixth * (k1.travel + 2.0 * (k2.travel + k3.travel) + k4.travel),
        )

    def rates(self, velocity: float, hydraulic_force: float, d1: float, drive: float) -> NominalMotion:
        """d/dt of both states, with d2 + g2 u given, and of the way."""
        acceleration = self.f1(velocity) + self.g1() * hydraulic_force + d1
        return NominalMotion(acceleration, self.f2(velocity, hydraulic_force) + drive, velocity)


class ThisMachine(NamedTuple):
    """In place of a law's model: that of the loop's own machine, which is filled in before a run.

    Its numbers are there to be read and changed once :func:`~hydroservo.control.wiring.wired` has filled it
    in.
    """


THIS_MACHINE = cast("DesignModel", ThisMachine())
