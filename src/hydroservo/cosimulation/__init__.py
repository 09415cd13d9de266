"""FMUs that others wrote, as the load or the machine of a loop, by co-simulation in FMI 2.0 and 3.0."""

from hydroservo.cosimulation.coupled import coupled, first_force, is_foreign, refuse_foreign
from hydroservo.cosimulation.fmu import Fmu, Variable, digest_of, read_fmu
from hydroservo.cosimulation.foreign import Foreign, Parameter, Wire, class_of
from hydroservo.cosimulation.load import LOAD_INPUTS, LOAD_OUTPUTS, ForeignLoad
from hydroservo.cosimulation.machine import (
    MACHINE_INPUTS,
    MACHINE_OUTPUTS,
    ForeignMachine,
    NoSupply,
    ThroughFmu,
)

__all__ = [
    "LOAD_INPUTS",
    "LOAD_OUTPUTS",
    "MACHINE_INPUTS",
    "MACHINE_OUTPUTS",
    "Fmu",
    "Foreign",
    "ForeignLoad",
    "ForeignMachine",
    "NoSupply",
    "Parameter",
    "ThroughFmu",
    "Variable",
    "Wire",
    "class_of",
    "coupled",
    "digest_of",
    "first_force",
    "is_foreign",
    "read_fmu",
    "refuse_foreign",
]
