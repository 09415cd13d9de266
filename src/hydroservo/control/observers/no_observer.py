"""No observer: what is measured is taken as it is, and nothing is known of the disturbances."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core.assumptions import Assumption, Facts, below
from hydroservo.core.block import Field
from hydroservo.core.roles import Observer, role, without_estimates
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel


@without_estimates
class NoObserverState(NamedTuple):
    """What is measured; no estimate is made, and none is judged."""

    s1: Annotated[float, Field("m/s", "0: no observer surface s1")]
    s2: Annotated[float, Field("N", "0: no observer surface s2")]
    d1: Annotated[float, Field("m/s^2", "0: no estimate of d_L1")]
    d2: Annotated[float, Field("N/s", "0: no estimate of d_L2")]
    velocity: Annotated[float, Field("m/s", "measured velocity, which the law takes")]
    hydraulic_force: Annotated[float, Field("N", "measured hydraulic force, which the law takes")]


@role(Observer)
class NoObserver(NamedTuple):
    """In an observer's place: x1 and x2 as measured, d_L1 = d_L2 = 0.

    Source: what the laws are without an observer.
    Fails as the law does that it is in: what the model does not know stays as an error.
    """

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        model, largest = facts.model, facts.disturbances[0]
        if model is None:
            return []
        meaning = "d_L1, unknown to the law, is below 1 % of 1/m times the hydraulic force of the supply"
        held = 0.01 * model.g1() * model.plant.piston_area * model.supply.drop()
        return [below("disturbance unknown", meaning, largest, held, "m/s^2", measured=True)]

    def init(self) -> NoObserverState:
        return NoObserverState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, s: NoObserverState, model: DesignModel, y: Measurement, dt: float) -> NoObserverState:
        return NoObserverState(0.0, 0.0, 0.0, 0.0, y.velocity, y.hydraulic_force)
