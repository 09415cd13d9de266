"""What observers without surfaces of their own estimate."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field


class Estimates(NamedTuple):
    """Estimates at this sample. The surfaces s1 and s2, which a law expects of an observer, are 0."""

    s1: Annotated[float, Field("m/s", "0: no observer surface s1")]
    s2: Annotated[float, Field("N", "0: no observer surface s2")]
    d1: Annotated[float, Field("m/s^2", "estimate of the lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "estimate of the lumped disturbance d_L2")]
    velocity: Annotated[float, Field("m/s", "velocity, which the law takes")]
    hydraulic_force: Annotated[float, Field("N", "hydraulic force, which the law takes")]
