"""What travels between blocks: plain records of SI numbers."""

from typing import Annotated, Any, NamedTuple

from hydroservo.core import ops
from hydroservo.core.field import Field


class Demand(NamedTuple):
    """What the controlled signal should be, with its first two derivatives, at one instant."""

    value: Annotated[float, Field("y", "{y} demand")]
    rate: Annotated[float, Field("y/s", "first derivative of the {y} demand")]
    second_rate: Annotated[float, Field("y/s^2", "second derivative of the {y} demand")]


class Measurement(NamedTuple):
    """What a controller is given at a sample."""

    velocity: Annotated[float, Field("m/s", "x1, piston velocity")]
    hydraulic_force: Annotated[float, Field("N", "x2 = A_p p_L")]
    position: Annotated[float, Field("m", "piston position from the stroke's lower end")]
    command: Annotated[float, Field("V", "mean of u as applied over the period just ended")]
    pressure_a: Annotated[float, Field("Pa", "pressure in chamber A")]
    pressure_b: Annotated[float, Field("Pa", "pressure in chamber B")]
    force: Annotated[float, Field("N", "force of the rod on what resists it, without inertia")]

    def with_command(self, command: float) -> "Measurement":
        """What a nested law is given, with its own share of the applied command [V]."""
        return Measurement(
            self.velocity,
            self.hydraulic_force,
            self.position,
            command,
            self.pressure_a,
            self.pressure_b,
            self.force,
        )


class MachineOutputs(NamedTuple):
    """What of the machine sensors can see."""

    velocity: Annotated[float, Field("m/s", "piston velocity")]
    hydraulic_force: Annotated[float, Field("N", "force of both chambers on the piston")]
    position: Annotated[float, Field("m", "piston position from the stroke's lower end")]
    pressure_a: Annotated[float, Field("Pa", "pressure in chamber A")]
    pressure_b: Annotated[float, Field("Pa", "pressure in chamber B")]
    force: Annotated[float, Field("N", "force of the rod on what resists it, without inertia")]


Seen = Measurement | MachineOutputs  # both have what a loop may control under the same names


class Pressures(NamedTuple):
    """What a supply holds ready at the valve; gauge, as all pressures."""

    supply: Annotated[float, Field("Pa", "pressure at port P")]
    tank: Annotated[float, Field("Pa", "pressure at port T, of the return line")]


class Feed(NamedTuple):
    """What a drive finds at its side away from the cylinder."""

    command: float  # u [V]
    edges: Any  # what the valve's spool opens
    opening: float  # of the valve's spool [m]
    line: Pressures  # the pressures of the supply's line

    def with_supply(self, pressure: float) -> "Feed":
        """What a drive finds that is fed with another pressure [Pa] than the supply's."""
        return Feed(self.command, self.edges, self.opening, Pressures(pressure, self.line.tank))

    def sensed(self, pressure_a: float, pressure_b: float) -> float:
        """The load [Pa]: the pressure at the port that the spool opens to P, or the tank's with it at 0."""
        closed = ops.where(self.opening < 0.0, pressure_b, self.line.tank)
        return ops.where(self.opening > 0.0, pressure_a, closed)


class EdgeOpenings(NamedTuple):
    """How far each edge of a spool is open, as a straight one; below 0, by how much it overlaps."""

    pa: Annotated[float, Field("m", "of the edge P-A")]
    at: Annotated[float, Field("m", "of the edge A-T")]
    pb: Annotated[float, Field("m", "of the edge P-B")]
    bt: Annotated[float, Field("m", "of the edge B-T")]


class PortFlows(NamedTuple):
    """What passes the four ports of a valve, or of what stands in its place."""

    a: Annotated[float, Field("m^3/s", "out of port A, into chamber A")]
    b: Annotated[float, Field("m^3/s", "into port B, out of chamber B")]
    supply: Annotated[float, Field("m^3/s", "into port P")]
    tank: Annotated[float, Field("m^3/s", "out of port T")]


class Tip(NamedTuple):
    """How the tip of a mechanism moves in its vertical plane as the rod does.

    Its place (X, Y), Y upwards, and the angle of the part it sits on, by the rod's position x.
    """

    across: Annotated[float, Field("", "dX/dx")]
    up: Annotated[float, Field("", "dY/dx")]
    across_slope: Annotated[float, Field("1/m", "d^2X/dx^2")]
    up_slope: Annotated[float, Field("1/m", "d^2Y/dx^2")]
    turn: Annotated[float, Field("rad/m", "turning of the part with the tip, from X to Y")]


class Correction(NamedTuple):
    """An observer's correction on one of its surfaces."""

    surface: float  # s_i as the realisation takes it, in the unit of x_i
    estimate: float  # of the lumped disturbance, in the unit of x_i per second


class ReachingRate(NamedTuple):
    """How a law draws a surface to 0."""

    rate: float  # in the unit of the surface per second, of its sign
    slope: float  # [1/s] derivative of the rate by the surface


class VelocityError(NamedTuple):
    """The velocity's error, and how an observer's surfaces shift that of its rate."""

    value: Annotated[float, Field("m/s", "velocity less demand e, with the observer's surface s1 in it")]
    rate: Annotated[float, Field("m/s^2", "its rate de/dt by model and estimates")]
    force_surface: Annotated[float, Field("m/s^2", "g1 s2, of the observer's surface s2")]
    velocity_surface: Annotated[float, Field("m/s^2", "f1' s1, of the observer's surface s1")]

    def shift(self) -> float:
        """s' = g1 s2 + f1' s1 [m/s^2], 0 with most observers."""
        return self.force_surface + self.velocity_surface


class Draws(NamedTuple):
    """Where a block draws its random numbers at a sample.

    A block with n sources of randomness draws from the streams stream ... stream + n - 1, each once a
    sample, as ``ops.normal(draws.seed, draws.stream + 1.0, draws.sample)``; a block that nests another
    which draws hands it a stream beyond its own.
    """

    seed: Annotated[float, Field("", "seed of the run, a whole number")]
    stream: Annotated[float, Field("", "first stream of the block, a whole and even number")]
    sample: Annotated[float, Field("", "number of the sample, 0 at the start")]
