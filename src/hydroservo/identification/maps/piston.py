"""What maps have to know of a scenario's plant."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ScenarioError

Samples = NDArray[np.float64]


class Piston(NamedTuple):
    """The piston of a plant.

    Attributes:
        plant: the plant.
        area_a: of chamber A [m^2].
        area_b: of chamber B [m^2].
    """

    plant: Any
    area_a: float
    area_b: float

    @property
    def has_chambers(self) -> bool:
        """Whether it is a cylinder with two chambers, and not one described by its load pressure."""
        return hasattr(self.plant, "volume_a")

    def volumes(self, position: Samples) -> tuple[Samples, Samples]:
        """V_A and V_B [m^3]; of a plant described by its load pressure, half of V_t each."""
        if not self.has_chambers:
            half = np.full(position.size, 0.5 * self.plant.total_volume)
            return half, half
        a, b = zip(
            *((self.plant.volume_a(x), self.plant.volume_b(x)) for x in position.tolist()), strict=True
        )
        return np.array(a), np.array(b)

    def inertia(self, position: float) -> float:
        """The moving mass [kg]."""
        if not self.has_chambers:
            return float(self.plant.mass)
        carried = self.plant.carried
        return float(carried.inertia(carried.init(), self.plant.mechanism, position))

    def resistance(self, position: float, velocity: float) -> float:
        """What the mechanism resists with at a steady speed, without friction of the piston [N]."""
        if not self.has_chambers:
            return 0.0
        carried = self.plant.carried
        return float(carried.resistance(carried.init(), self.plant.mechanism, position, velocity))


def piston_of(plant: Any, scenario: str) -> Piston:
    """The piston of a scenario's plant.

    Raises:
        ScenarioError: the plant has no areas that are known here.
    """
    if hasattr(plant, "piston_area") and hasattr(plant, "total_volume"):
        return Piston(plant, plant.piston_area, plant.piston_area)
    if hasattr(plant, "volume_a") and hasattr(plant, "area_a"):
        return Piston(plant, plant.area_a, plant.area_b)
    problem = f"{type(plant).__name__} has no piston areas and volumes; Cylinder and LoadPressurePlant have"
    raise ScenarioError(scenario, "plant.type", problem)
