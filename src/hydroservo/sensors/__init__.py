"""What the controller sees of the machine."""

from hydroservo.sensors.ideal import IdealSensors, IdealSensorsState
from hydroservo.sensors.noisy import NoisySensors, NoisySensorsState

__all__ = [
    "IdealSensors",
    "IdealSensorsState",
    "NoisySensors",
    "NoisySensorsState",
]
