"""FMUs that others wrote, as the load or the machine of a loop, by co-simulation in FMI 2.0 and 3.0."""

from hydroservo.cosimulation.blocks import (
    LOAD_INPUTS,
    LOAD_OUTPUTS,
    MACHINE_INPUTS,
    MACHINE_OUTPUTS,
    ForeignLoad,
    ForeignMachine,
    NoSupply,
    ThroughFmu,
)
from hydroservo.cosimulation.coupled import couple_fmus, first_force, has_fmu, refuse_fmus
from hydroservo.cosimulation.fmu import (
    Fmu,
    FmuVariable,
    Foreign,
    Parameter,
    Wire,
    digest_of,
    fmu_block_class,
    read_fmu,
)

__all__ = [
    "LOAD_INPUTS",
    "LOAD_OUTPUTS",
    "MACHINE_INPUTS",
    "MACHINE_OUTPUTS",
    "Fmu",
    "FmuVariable",
    "Foreign",
    "ForeignLoad",
    "ForeignMachine",
    "NoSupply",
    "Parameter",
    "ThroughFmu",
    "Wire",
    "couple_fmus",
    "digest_of",
    "first_force",
    "fmu_block_class",
    "has_fmu",
    "read_fmu",
    "refuse_fmus",
]
