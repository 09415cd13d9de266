"""What the controller sees of the machine."""

from hydroservo.machine.sensors.delayed import DelayedSensors, DelayedSensorsState
from hydroservo.machine.sensors.difference import Difference, DifferenceState
from hydroservo.machine.sensors.dropout import Dropout, DropoutState
from hydroservo.machine.sensors.encoder import Encoder
from hydroservo.machine.sensors.exact_differentiator import ExactDifferentiator, ExactDifferentiatorState
from hydroservo.machine.sensors.filtered_difference import FilteredDifference, FilteredDifferenceState
from hydroservo.machine.sensors.ideal import IdealSensors, IdealSensorsState
from hydroservo.machine.sensors.ideal_position import IdealPosition, PositionReading
from hydroservo.machine.sensors.load_cell import LoadCell
from hydroservo.machine.sensors.no_force import ForceReading, NoForce
from hydroservo.machine.sensors.no_position import NoPosition
from hydroservo.machine.sensors.no_pressure import NoPressure, PressureReading
from hydroservo.machine.sensors.noisy import NoisySensors, NoisySensorsState
from hydroservo.machine.sensors.pressure_transducer import PressureTransducer, PressureTransducerState
from hydroservo.machine.sensors.rig import RigSensors, RigSensorsState
from hydroservo.machine.sensors.velocity_sensor import VelocityReading, VelocitySensor

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
