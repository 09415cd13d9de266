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
    couple_fmus,
    first_force,
    has_fmu,
    refuse_fmus,
)

__all__ = [
    "LOAD_INPUTS",
    "LOAD_OUTPUTS",
    "MACHINE_INPUTS",
    "MACHINE_OUTPUTS",
    "ForeignLoad",
    "ForeignMachine",
    "NoSupply",
    "ThroughFmu",
    "couple_fmus",
    "first_force",
    "has_fmu",
    "refuse_fmus",
]
