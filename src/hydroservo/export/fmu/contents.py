"""What an FMU is made of: description, sources, documentation."""

import hashlib
import uuid
from collections.abc import Mapping, Sequence
from importlib import metadata, resources
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.export.compilers import BITS
from hydroservo.export.fmu.variables import VariableKind, base_unit, clock_after, structure_of, variables_of
from hydroservo.export.texts import render
from hydroservo.export.unit import CModule, FmiVersion, Part

Files = dict[str, str]
"""Texts by their path in the FMU."""


class Interface(NamedTuple):
    """What an FMU of one version of FMI needs, for co-simulation or model exchange."""

    description: str  # template of modelDescription.xml
    sources: tuple[str, ...]  # the files of this package to compile
    own_headers: tuple[str, ...]  # of this package
    headers: tuple[str, ...]  # of FMI
    unprefixed: str  # macro that gives the functions of a shared library their names without a prefix
    first_index: int  # what ModelStructure counts variables from
    texts: Mapping[str, str]  # templates of more files, by their path in the FMU
    clocked: bool = False  # the ticks of a clock take the samples


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
        sources=(*FMI2_SOURCES, "equations.c", "fmi2_equations.c"), own_headers=("instance.h", "equations.h")
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


UNPREFIXED = "#define fmi2FullName(name) name\n"
PREFIXED = """\
#ifdef FMI2_FUNCTION_PREFIX
#define FMU_JOINED_TEXT(prefix, name) prefix##name
#define FMU_JOINED(prefix, name) FMU_JOINED_TEXT(prefix, name)
#define fmi2FullName(name) FMU_JOINED(FMI2_FUNCTION_PREFIX, name)
#else
#define fmi2FullName(name) name
#endif
"""


def fmu_files(unit: CModule, stop_time: float, version: FmiVersion, clocked: bool = False) -> Files:
    """All but the binary.

    The token that ties the description to the sources is a digest of both, so that equal exports have equal
    tokens and others have others.
    """
    interface = interface_of(version, unit.part, clocked)
    context = context_of(unit, stop_time, version, interface)
    plain = model_files(unit, interface, {**context, "token": ""})
    digest = hashlib.sha256("\0".join(part for one in sorted(plain.items()) for part in one).encode())
    token = str(uuid.UUID(digest.hexdigest()[:32]))
    files = model_files(unit, interface, {**context, "token": token})
    own = {f"sources/include/{name}": text for name, text in headers(interface.headers).items()}
    return files | documentation(context) | own


def context_of(unit: CModule, stop_time: float, version: FmiVersion, interface: Interface) -> dict[str, Any]:
    """What the templates are filled with."""
    variables = variables_of(unit)
    clock = clock_after(variables) if interface.clocked else None
    return {
        "unit": unit,
        "interface": "ModelExchange" if unit.part is Part.EQUATIONS else "CoSimulation",
        "version": version,
        "description": f"{unit.title}; hash {unit.hash}",
        "stop_time": stop_time,
        "variables": variables,
        "clock": clock,
        "structure": structure_of(unit, variables, clock),
        "first_index": interface.first_index,
        "integrated": [one for one in variables if one.kind is VariableKind.INTEGRATED],
        "rates": [one for one in variables if one.kind is VariableKind.RATE],
        "units": {one.unit: base_unit(one.unit) for one in variables if one.unit},
        "sources": [f"{unit.prefix}.c", "model.c", *interface.sources],
        "options": BITS,
        "parameters": ", &numbers->parameters" if unit.parameters else "",
    }


def model_files(unit: CModule, interface: Interface, context: Mapping[str, Any]) -> Files:
    """The model description and the sources."""
    folder = resources.files("hydroservo.export.fmu") / "sources"
    own = (*interface.sources, *interface.own_headers)
    return {
        "modelDescription.xml": render(interface.description, context),
        f"sources/{unit.prefix}.h": unit.header,
        f"sources/{unit.prefix}.c": unit.source,
        "sources/model.h": render("fmu/model.h", context),
        "sources/model.c": render("fmu/model.c", context),
        **{path: render(template, context) for path, template in interface.texts.items()},
        **{f"sources/{name}": (folder / name).read_text("utf-8") for name in own},
    }


def documentation(context: Mapping[str, Any]) -> Files:
    return {
        "documentation/index.html": render("fmu/index.html", context),
        "documentation/scenario.toml": context["unit"].scenario,
        "documentation/licenses/license.txt": render("fmu/license.txt", {"own": licence("hydroservo")}),
        "documentation/licenses/fmpy.txt": licence("fmpy"),
    }


def headers(names: Sequence[str]) -> dict[str, str]:
    """FMI's headers by name.

    The package fmpy took the prefix out of that of FMI 2.0, as it builds shared libraries alone; here it is
    back, as the standard has it, so that several FMUs can be linked into one program.
    """
    folder = Path(str(installed_package("fmpy").locate_file("fmpy/c-code")))
    return {name: (folder / name).read_text("utf-8").replace(UNPREFIXED, PREFIXED) for name in names}


def licence(name: str) -> str:
    """The licence text that an installed package ships."""
    for file in installed_package(name).files or ():
        if file.name in ("LICENSE", "LICENSE.txt"):
            return file.read_text("utf-8")
    raise HydroservoError(f"the package {name} came without its licence; install it again")


def installed_package(name: str) -> metadata.Distribution:
    try:
        return metadata.distribution(name)
    except metadata.PackageNotFoundError:
        raise HydroservoError(f"an FMU needs the package {name}: pip install '.[fmu]' in a clone") from None
