"""What an FMU is made of, by the version of FMI and by what it is for."""

from collections.abc import Mapping
from typing import NamedTuple

from hydroservo.errors import ParameterError
from hydroservo.export.unit import FmiVersion, Part


class Interface(NamedTuple):
    """What an FMU of one version of FMI needs, for co-simulation or model exchange.

    Attributes:
        description: template of modelDescription.xml.
        sources: the files of this package to compile.
        own_headers: of this package.
        headers: of FMI.
        unprefixed: macro that gives the functions of a shared library their names without a prefix.
        first_index: what ModelStructure counts variables from.
        texts: templates of more files, by their path in the FMU.
        clocked: the ticks of a clock take the samples.
    """

    description: str
    sources: tuple[str, ...]
    own_headers: tuple[str, ...]
    headers: tuple[str, ...]
    unprefixed: str
    first_index: int
    texts: Mapping[str, str]
    clocked: bool = False


FMI2_SOURCES = ("instance.c", "fmi2.c")
FMI3_SOURCES = ("instance.c", "fmi3.c", "fmi3_unused.c")

CO_SIMULATION = {
    FmiVersion.FMI2: Interface(
        "fmu/modelDescription2.xml",
        (*FMI2_SOURCES, "samples.c", "steps.c", "fmi2_steps.c"),
        ("instance.h", "samples.h", "steps.h"),
        ("fmi2FunctionTypes.h", "fmi2Functions.h", "fmi2TypesPlatform.h"),
        "FMI2_OVERRIDE_FUNCTION_PREFIX",
        1,
        {},
    ),
    FmiVersion.FMI3: Interface(
        "fmu/modelDescription3.xml",
        (
            *FMI3_SOURCES,
            "samples.c",
            "steps.c",
            "fmi3_steps.c",
            "fmi3_no_events.c",
            "fmi3_no_clocks.c",
            "fmi3_no_equations.c",
        ),
        ("instance.h", "samples.h", "steps.h", "fmi3_common.h"),
        ("fmi3FunctionTypes.h", "fmi3Functions.h", "fmi3PlatformTypes.h"),
        "FMI3_OVERRIDE_FUNCTION_PREFIX",
        0,
        {"sources/buildDescription.xml": "fmu/buildDescription.xml"},
    ),
}

MODEL_EXCHANGE = {
    FmiVersion.FMI2: CO_SIMULATION[FmiVersion.FMI2]._replace(
        sources=(*FMI2_SOURCES, "equations.c", "fmi2_equations.c"),
        own_headers=("instance.h", "equations.h"),
    ),
    FmiVersion.FMI3: CO_SIMULATION[FmiVersion.FMI3]._replace(
        sources=(*FMI3_SOURCES, "equations.c", "fmi3_equations.c", "fmi3_no_steps.c", "fmi3_no_clocks.c"),
        own_headers=("instance.h", "equations.h", "fmi3_common.h"),
    ),
}

CLOCKED = CO_SIMULATION[FmiVersion.FMI3]._replace(
    sources=(*FMI3_SOURCES, "samples.c", "ticks.c", "fmi3_steps.c", "fmi3_ticks.c", "fmi3_no_equations.c"),
    own_headers=("instance.h", "samples.h", "steps.h", "ticks.h", "fmi3_common.h"),
    clocked=True,
)


def interface_of(version: FmiVersion, part: Part, clocked: bool = False) -> Interface:
    """What a version of FMI needs: of equations for model exchange, else for co-simulation."""
    if clocked:
        check_clock(version, part)
        return CLOCKED
    return (MODEL_EXCHANGE if part is Part.EQUATIONS else CO_SIMULATION)[version]


def check_clock(version: FmiVersion, part: Part) -> None:
    """Find out whether an FMU can have a clock.

    Raises:
        ParameterError: its version of FMI has none, or its part does not wait for inputs.
    """
    if version is FmiVersion.FMI2:
        raise ParameterError("clocked", True, "FMI 2.0 has no clocks; use FMI 3.0")
    if part is not Part.CONTROLLER:
        raise ParameterError("clocked", True, f"only a controller can have a clock, and this is of {part}")
