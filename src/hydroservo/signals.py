"""What travels between blocks: plain records of SI numbers."""

from typing import Annotated, NamedTuple

from hydroservo.field import Field

__all__ = ["Correction", "Demand", "Draws", "Measurement"]


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
    command: Annotated[float, Field("V", "u that was applied over the period just ended")]


class Correction(NamedTuple):
    """An observer's correction on one of its surfaces."""

    surface: float  # s_i as the realisation takes it, in the unit of x_i
    estimate: float  # of the lumped disturbance, in the unit of x_i per second


class Draws(NamedTuple):
    """Where a block draws its random numbers at a sample.

    A block with n sources of randomness draws from the streams stream ... stream + n - 1, each once a
    sample, as ``ops.normal(draws.seed, draws.stream + 1.0, draws.sample)``; a block that nests another
    which draws hands it a stream beyond its own.
    """

    seed: Annotated[float, Field("", "seed of the run, a whole number")]
    stream: Annotated[float, Field("", "first stream of the block, a whole and even number")]
    sample: Annotated[float, Field("", "number of the sample, 0 at the start")]
