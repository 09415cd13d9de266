"""The toy in the other forms that an export may have."""

import re

import numpy as np
import pytest
from numpy.typing import NDArray

from hydroservo.export.unit import CModule, Part
from tests.support.export.toy import toy
from tools.targets.sources import width

GIVEN = ", const toy_parameters *parameters"
NUMBER = re.compile(r"\b(\d+\.\d+|\d+e-\d+)\b")


def changed(unit: CModule, old: str, new: str) -> CModule:
    """A unit with another text in its source."""
    assert old in unit.source
    return unit._replace(source=unit.source.replace(old, new))


def single() -> CModule:
    unit = toy()
    header, source = (text.replace("double", "float") for text in (unit.header, unit.source))
    return unit._replace(real="float", header=header, source=NUMBER.sub(r"\1f", source))


def inlined() -> CModule:
    unit = toy()
    header = re.sub(r"/\* Saturation.*} toy_parameters;\n\n", "", unit.header, flags=re.DOTALL)
    header = header.replace(GIVEN, "").replace("extern const toy_parameters toy_defaults;\n\n", "")
    source = re.sub(r"const toy_parameters.*?};\n\n", "", unit.source, flags=re.DOTALL)
    source = source.replace(GIVEN, "").replace("    (void)parameters;\n", "")
    source = source.replace("const toy_saturation *self, ", "").replace("&parameters->saturation, ", "")
    for name, value in {
        "self->limit": "10.0",
        "parameters->proportional_gain": "100.0",
        "parameters->integral_gain": "10.0",
        "parameters->period": "1e-05",
    }.items():
        source = source.replace(name, value)
    return unit._replace(inlined=True, header=header, source=source)


def without_arguments() -> CModule:
    """An integrator that drives itself; its step returns nothing."""
    unit = toy()
    arguments = ", const toy_measurement *measurement,\n                const toy_demand *demand"
    header = re.sub(r"typedef struct {[^}]*} toy_(measurement|demand);\n\n", "", unit.header)
    header = header.replace(arguments, "").replace("double toy_step", "void toy_step")
    source = unit.source.replace(arguments, "").replace("double toy_step", "void toy_step")
    source = source.replace("demand->value - measurement->velocity", "0.5 - state->integral")
    source = source.replace("    return state->u;\n", "")
    return unit._replace(header=header, source=source, arguments=(), part=Part.LOOP)


def idling(instructions: int) -> CModule:
    """The toy with a step that does nothing for some instructions first."""
    idle = f'    __asm__ volatile(".rept {instructions}\\n nop\\n .endr");\n'
    return changed(toy(), "    const double error", f"{idle}    const double error")


UNITS = {"double": toy, "single": single, "inlined": inlined, "without arguments": without_arguments}
each_unit = pytest.mark.parametrize("unit", [make() for make in UNITS.values()], ids=UNITS)


def inputs(unit: CModule, rows: int = 200) -> NDArray[np.float64]:
    """Rows of numbers as small as velocities are, the same each time."""
    return np.random.default_rng(0).normal(0.0, 0.05, (rows, width(unit)))
