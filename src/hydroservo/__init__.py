"""A workbench for electro-hydraulic servo actuators."""

from hydroservo._version import __version__
from hydroservo.batch import simulate_batch
from hydroservo.block import Field, replace
from hydroservo.errors import HydroservoError, HydroservoWarning, LoopError, ParameterError, ScenarioError
from hydroservo.loop import AUTO, Loop, Simulation
from hydroservo.simulate import simulate

__all__ = [
    "AUTO",
    "Field",
    "HydroservoError",
    "HydroservoWarning",
    "Loop",
    "LoopError",
    "ParameterError",
    "ScenarioError",
    "Simulation",
    "__version__",
    "replace",
    "simulate",
    "simulate_batch",
]
