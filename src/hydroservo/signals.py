"""What travels between blocks: plain records of SI numbers."""

from typing import Annotated, NamedTuple

from hydroservo.field import Field

__all__ = ["Correction", "Demand", "Measurement"]


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
