"""Actuators: cylinders and the mass they move."""

from hydroservo.plants.cylinder import Cylinder, CylinderState
from hydroservo.plants.design_model import DesignModel, NominalMotion, ThisMachine
from hydroservo.plants.load_pressure import LoadPressurePlant, LoadPressureState

__all__ = [
    "Cylinder",
    "CylinderState",
    "DesignModel",
    "LoadPressurePlant",
    "LoadPressureState",
    "NominalMotion",
    "ThisMachine",
]
