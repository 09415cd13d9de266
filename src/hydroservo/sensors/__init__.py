"""What the controller sees of the machine."""

from hydroservo.sensors.delayed import DelayedSensors, DelayedSensorsState
from hydroservo.sensors.difference import Difference, DifferenceState
from hydroservo.sensors.dropout import Dropout, DropoutState
from hydroservo.sensors.encoder import Encoder
from hydroservo.sensors.exact_differentiator import ExactDifferentiator, ExactDifferentiatorState
from hydroservo.sensors.filtered_difference import FilteredDifference, FilteredDifferenceState
from hydroservo.sensors.ideal import IdealSensors, IdealSensorsState
from hydroservo.sensors.ideal_position import IdealPosition, PositionReading
from hydroservo.sensors.load_cell import LoadCell
from hydroservo.sensors.no_force import ForceReading, NoForce
from hydroservo.sensors.no_position import NoPosition
from hydroservo.sensors.no_pressure import NoPressure, PressureReading
from hydroservo.sensors.noisy import NoisySensors, NoisySensorsState
from hydroservo.sensors.pressure_transducer import PressureTransducer, PressureTransducerState
from hydroservo.sensors.rig import RigSensors, RigSensorsState
from hydroservo.sensors.velocity_sensor import VelocityReading, VelocitySensor

__all__ = [
    "DelayedSensors",
    "DelayedSensorsState",
    "Difference",
    "DifferenceState",
    "Dropout",
    "DropoutState",
    "Encoder",
    "ExactDifferentiator",
    "ExactDifferentiatorState",
    "FilteredDifference",
    "FilteredDifferenceState",
    "ForceReading",
    "IdealPosition",
    "IdealSensors",
    "IdealSensorsState",
    "LoadCell",
    "NoForce",
    "NoPosition",
    "NoPressure",
    "NoisySensors",
    "NoisySensorsState",
    "PositionReading",
    "PressureReading",
    "PressureTransducer",
    "PressureTransducerState",
    "RigSensors",
    "RigSensorsState",
    "VelocityReading",
    "VelocitySensor",
]
