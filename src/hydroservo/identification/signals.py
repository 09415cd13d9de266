"""What a log may hold of a machine: what drives it, and what is measured of it."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from hydroservo.field import Field, declared_fields
from hydroservo.signals import MachineOutputs

TIME = "time"
COMMAND = "command"
EXTERNAL_FORCE = "external_force"
REFERENCE = "reference"

INPUTS: Mapping[str, Field] = MappingProxyType(
    {
        COMMAND: Field("V", "command of the valve or the pump"),
        EXTERNAL_FORCE: Field("N", "external force on the rod, positive against motion"),
    }
)
"""What drives the machine: the command must be there; a force stands in place of the scenario's load."""

OUTPUTS: Mapping[str, Field] = MappingProxyType(dict(declared_fields(MachineOutputs)))
"""What is measured; at least one of these must be there."""

SIGNALS: Mapping[str, Field] = MappingProxyType({TIME: Field("s", "time"), **INPUTS, **OUTPUTS})
"""All of them, in SI units, by the name that a column of a log has."""

NAMES = (*SIGNALS, REFERENCE)
"""What a scenario may say the column of: the demand too, whose unit is that of what is controlled."""

WRITTEN: Mapping[str, Sequence[str]] = MappingProxyType(
    {
        TIME: ("t", "timestamp", "datetime"),
        COMMAND: ("controller.u",),
        EXTERNAL_FORCE: ("load.force",),
        REFERENCE: ("reference.value",),
    }
    | {name: (f"sensors.{name}.value", f"sensors.{name}", f"plant.{name}") for name in OUTPUTS}
)
"""Other usual names, and the columns of a run's trajectory, which is a log too, measured ones first."""
