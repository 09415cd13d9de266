"""Sensors that see the state itself."""

from typing import NamedTuple

from hydroservo.plants.load_pressure import LoadPressureState
from hydroservo.signals import Measurement

__all__ = ["IdealSensors"]


class IdealSensors(NamedTuple):
    """Velocity, load pressure and position without noise, delay or quantisation.

    Source: Sec. 2 of doi:10.1007/s42401-021-00087-w takes both states as measured.
    Fails on every real rig: velocity comes from an encoder there, and pressure with noise.
    """

    def measure(self, plant: LoadPressureState, command: float) -> Measurement:
        return Measurement(plant.velocity, plant.load_force, plant.position, command)
