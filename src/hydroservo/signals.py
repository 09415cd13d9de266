"""What travels between blocks: plain records of SI numbers."""

from typing import Annotated, NamedTuple

from hydroservo.field import Field

__all__ = [
    "Correction",
    "Demand",
    "Draws",
    "MachineOutputs",
    "Measurement",
    "PortFlows",
    "Pressures",
    "Pull",
]


class Demand(NamedTuple):
    """A velocity demand and its first two derivatives at one instant."""

    value: Annotated[float, Field("m/s", "velocity demand dy_d/dt")]
    rate: Annotated[float, Field("m/s^2", "first derivative of the velocity demand")]
    jerk: Annotated[float, Field("m/s^3", "second derivative of the velocity demand")]


class Measurement(NamedTuple):
    """What a controller is given at a sample."""

    velocity: Annotated[float, Field("m/s", "x1, piston velocity")]
    load_force: Annotated[float, Field("N", "x2 = A_p p_L")]
    position: Annotated[float, Field("m", "piston position from the stroke's lower end")]
    command: Annotated[float, Field("V", "mean of u as applied over the period just ended")]
    pressure_a: Annotated[float, Field("Pa", "pressure in chamber A")]
    pressure_b: Annotated[float, Field("Pa", "pressure in chamber B")]


class MachineOutputs(NamedTuple):
    """What of the machine sensors can see."""

    velocity: Annotated[float, Field("m/s", "piston velocity")]
    load_force: Annotated[float, Field("N", "force of both chambers on the piston")]
    position: Annotated[float, Field("m", "piston position from the stroke's lower end")]
    pressure_a: Annotated[float, Field("Pa", "pressure in chamber A")]
    pressure_b: Annotated[float, Field("Pa", "pressure in chamber B")]


class Pressures(NamedTuple):
    """What a supply holds ready at the valve; gauge, as all pressures."""

    supply: Annotated[float, Field("Pa", "pressure at port P")]
    tank: Annotated[float, Field("Pa", "pressure at port T, of the return line")]


class PortFlows(NamedTuple):
    """What passes the four ports of a valve."""

    a: Annotated[float, Field("m^3/s", "out of port A, into chamber A")]
    b: Annotated[float, Field("m^3/s", "into port B, out of chamber B")]
    supply: Annotated[float, Field("m^3/s", "into port P")]
    tank: Annotated[float, Field("m^3/s", "out of port T")]


class Correction(NamedTuple):
    """An observer's correction on one of its surfaces."""

    surface: float  # s_i as the realisation takes it, in the unit of x_i
    estimate: float  # of the lumped disturbance, in the unit of x_i per second


class Pull(NamedTuple):
    """How a law draws a surface to 0."""

    rate: float  # in the unit of the surface per second, of its sign
    slope: float  # [1/s] derivative of the rate by the surface


class Draws(NamedTuple):
    """Where a block draws its random numbers at a sample.

    A block with n sources of randomness draws from the streams stream ... stream + n - 1, each once a
    sample, as ``ops.normal(draws.seed, draws.stream + 1.0, draws.sample)``; a block that nests another
    which draws hands it a stream beyond its own.
    """

    seed: Annotated[float, Field("", "seed of the run, a whole number")]
    stream: Annotated[float, Field("", "first stream of the block, a whole and even number")]
    sample: Annotated[float, Field("", "number of the sample, 0 at the start")]
