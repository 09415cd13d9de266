"""The derivative of a signal, taken from the nominal model."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Differentiator, role


class ModelDerivativeState(NamedTuple):
    """The last rate."""

    rate: Annotated[float, Field("", "rate by the nominal model, in the signal's unit per second")]


@role(Differentiator)
class ModelDerivative(NamedTuple):
    """The rate that the caller derived from its model, passed through.

    A signal that no model describes (a disturbance estimate) is taken as constant.

    Source: the analytic derivative of the virtual control in backstepping, Krstic, Kanellakopoulos,
    Kokotovic, Nonlinear and Adaptive Control Design, 1995, ch. 2.
    Fails where the model does: unmodelled load and parameters are missing from the rate.
    """

    def init(self) -> ModelDerivativeState:
        return ModelDerivativeState(0.0)

    def step(
        self, s: ModelDerivativeState, value: float, model_rate: float, dt: float
    ) -> ModelDerivativeState:
        return ModelDerivativeState(model_rate)
