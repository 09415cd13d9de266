"""The integral criteria of the error."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role


class IntegralCriteriaState(NamedTuple):
    """The integrals so far."""

    absolute: float
    squares: float
    weighted: float


class IntegralCriteriaValues(NamedTuple):
    """The integrals over the run."""

    iae: Annotated[float, Field("y s", "integral of |error|", smaller_is_better=True)]
    ise: Annotated[float, Field("y^2 s", "integral of error^2", smaller_is_better=True)]
    itae: Annotated[float, Field("y s^2", "integral of t |error|", smaller_is_better=True)]


@role(Monitor)
class IntegralCriteria(NamedTuple):
    """IAE, ISE and ITAE of the error e = r - y of the controlled signal.

    IAE = integral of |e| dt, ISE = integral of e^2 dt, ITAE = integral of t |e| dt, by the left rule over the
    integrator's steps. ITAE counts the time from the start of the run.

    Source: Graham, Lathrop, Transactions of the AIEE 72(5), 1953, doi:10.1109/TAI.1953.6371346.
    Fails to compare runs of different lengths; ITAE fails where the demand jumps late.
    """

    def init(self) -> IntegralCriteriaState:
        return IntegralCriteriaState(0.0, 0.0, 0.0)

    def step(
        self, m: IntegralCriteriaState, loop: Block, s: Block, t: float, dt: float
    ) -> IntegralCriteriaState:
        error = s.reference.value - s.controlled.value
        size = ops.absolute(error) * dt
        return IntegralCriteriaState(m.absolute + size, m.squares + error * error * dt, m.weighted + t * size)

    def values(self, m: IntegralCriteriaState) -> IntegralCriteriaValues:
        return IntegralCriteriaValues(m.absolute, m.squares, m.weighted)
