"""Actuators: cylinders and the mass they move."""

from hydroservo.machine.plants.cylinder import Cylinder, CylinderState
from hydroservo.machine.plants.design_model import DesignModel, NominalMotion, ThisMachine
from hydroservo.machine.plants.load_pressure import LoadPressurePlant, LoadPressureState

__all__ = [
    "Cylinder",
    "CylinderState",
    "DesignModel",
    "LoadPressurePlant",
    "LoadPressureState",
    "NominalMotion",
    "ThisMachine",
]
