"""The roles that a block can play: what each must be able to do.

A block says its role above its class::

    @role(Controller)
    class Proportional(NamedTuple): ...

A role is a Protocol: the methods that its blocks have, with as many arguments. What a block may have besides
is in :mod:`hydroservo.core.hooks`.
"""

from hydroservo.core.roles.laws import (
    Basis,
    ControlledSignal,
    Controller,
    Differentiator,
    ErrorDynamics,
    Filter,
    Hold,
    Integrator,
    Limiter,
    Model,
    Monitor,
    Observer,
    Reaching,
    Realisation,
    Reference,
    Start,
)
from hydroservo.core.roles.machine import (
    Accumulator,
    Carried,
    CheckFlow,
    Drive,
    EdgeShape,
    EndStops,
    ForceSensor,
    Friction,
    Load,
    Mechanism,
    MeteringEdges,
    Oil,
    Plant,
    Poppet,
    PositionSensor,
    PressureSensor,
    Relief,
    Sensors,
    Supply,
    Valve,
    VelocityEstimator,
)
from hydroservo.core.roles.saying import Block, at_samples, controlling, role, valveless, without_estimates

__all__ = [
    "Accumulator",
    "Basis",
    "Block",
    "Carried",
    "CheckFlow",
    "ControlledSignal",
    "Controller",
    "Differentiator",
    "Drive",
    "EdgeShape",
    "EndStops",
    "ErrorDynamics",
    "Filter",
    "ForceSensor",
    "Friction",
    "Hold",
    "Integrator",
    "Limiter",
    "Load",
    "Mechanism",
    "MeteringEdges",
    "Model",
    "Monitor",
    "Observer",
    "Oil",
    "Plant",
    "Poppet",
    "PositionSensor",
    "PressureSensor",
    "Reaching",
    "Realisation",
    "Reference",
    "Relief",
    "Sensors",
    "Start",
    "Supply",
    "Valve",
    "VelocityEstimator",
    "at_samples",
    "controlling",
    "role",
    "valveless",
    "without_estimates",
]
