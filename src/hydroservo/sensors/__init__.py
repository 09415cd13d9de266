"""What the controller sees of the machine."""

from hydroservo.sensors.ideal import IdealSensors

__all__ = [
    "IdealSensors",
]
