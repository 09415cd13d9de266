"""The two versions of FMI, and what differs between them in a file."""

import platform
import sys
from collections.abc import Mapping
from typing import NamedTuple

from hydroservo.errors import HydroservoError, ParameterError
from hydroservo.export.unit import FmiVersion, Part

__all__ = ["Interface", "binary_ending", "check_clock", "interface_of", "platform_folder"]

SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
ARCHITECTURES = {
    "x86_64": ("x86_64", "64"),
    "amd64": ("x86_64", "64"),
    "aarch64": ("aarch64", "64"),
    "arm64": ("aarch64", "64"),
    "i386": ("x86", "32"),
    "i686": ("x86", "32"),
}


class Interface(NamedTuple):
    """What one version of FMI needs, for co-simulation or model exchange.

    Attributes:
        description: template of modelDescription.xml.
        sources: the files of this package to compile.
        own_headers: of this package.
        headers: of FMI.
        unprefixed: macro that gives the functions of a shared library their names without a prefix.
        first_index: what ModelStructure counts variables from.
        texts: templates of more files, by their path in the FMU.
        clocked: samples are taken at the ticks of a clock.
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
INTERFACES = {
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
            *(*FMI3_SOURCES, "samples.c", "steps.c", "fmi3_steps.c"),
            *("fmi3_no_events.c", "fmi3_no_clocks.c", "fmi3_no_equations.c"),
        ),
        ("instance.h", "samples.h", "steps.h", "fmi3_common.h"),
        ("fmi3FunctionTypes.h", "fmi3Functions.h", "fmi3PlatformTypes.h"),
        "FMI3_OVERRIDE_FUNCTION_PREFIX",
        0,
        {"sources/buildDescription.xml": "fmu/buildDescription.xml"},
    ),
}


EXCHANGES = {
    FmiVersion.FMI2: INTERFACES[FmiVersion.FMI2]._replace(
        sources=(*FMI2_SOURCES, "equations.c", "fmi2_equations.c"),
        own_headers=("instance.h", "equations.h"),
    ),
    FmiVersion.FMI3: INTERFACES[FmiVersion.FMI3]._replace(
        sources=(*FMI3_SOURCES, "equations.c", "fmi3_equations.c", "fmi3_no_steps.c", "fmi3_no_clocks.c"),
        own_headers=("instance.h", "equations.h", "fmi3_common.h"),
    ),
}


CLOCKED = INTERFACES[FmiVersion.FMI3]._replace(
    sources=(*FMI3_SOURCES, "samples.c", "ticks.c", "fmi3_steps.c", "fmi3_ticks.c", "fmi3_no_equations.c"),
    own_headers=("instance.h", "samples.h", "steps.h", "ticks.h", "fmi3_common.h"),
    clocked=True,
)


def interface_of(version: FmiVersion, part: Part, clocked: bool = False) -> Interface:
    """What a version of FMI needs: of equations for model exchange, else for co-simulation.

    Raises:
        ParameterError: it is wanted with a clock and cannot have one.
    """
    if clocked:
        check_clock(version, part)
        return CLOCKED
    return (EXCHANGES if part is Part.EQUATIONS else INTERFACES)[version]


def check_clock(version: FmiVersion, part: Part) -> None:
    """Find out whether an FMU can have a clock.

    Raises:
        ParameterError: its version of FMI has none, or its part does not wait for inputs.
    """
    if version is FmiVersion.FMI2:
        raise ParameterError("clocked", True, "FMI 2.0 has no clocks; take FMI 3.0")
    if part is not Part.CONTROLLER:
        raise ParameterError("clocked", True, f"only a controller can have a clock, and this is of {part}")


def platform_folder(version: FmiVersion) -> str:
    """The folder of this machine's binaries in an FMU.

    Raises:
        HydroservoError: FMI has no name for this machine.
    """
    system, _ = system_of_this()
    machine = platform.machine().lower()
    if machine not in ARCHITECTURES:
        raise HydroservoError(f"FMI has no name for the machine {machine!r}; no FMU can be built on it")
    architecture, bits = ARCHITECTURES[machine]
    if version is FmiVersion.FMI3:
        return f"{architecture}-{system}"
    return f"{'win' if system == 'windows' else system}{bits}"


def binary_ending() -> str:
    """The ending of a shared library's name on this machine."""
    return system_of_this()[1]


def system_of_this() -> tuple[str, str]:
    if sys.platform not in SYSTEMS:
        raise HydroservoError(
            f"FMI has no name for the system {sys.platform!r}, so no FMU can be built on it"
        )
    return SYSTEMS[sys.platform]
