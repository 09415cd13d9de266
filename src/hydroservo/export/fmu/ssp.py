"""Writes a loop as a system of FMUs: System Structure and Parameterization, SSP 1.0."""

import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from hydroservo.core.errors import HydroservoError
from hydroservo.core.outputs import atomic_path
from hydroservo.export.compilers import platforms_named
from hydroservo.export.fmu.variables import FmiVariable, VariableKind, base_unit, variables_of
from hydroservo.export.fmu.write import checked_ending, fmu_content, pack
from hydroservo.export.texts import render
from hydroservo.export.unit import CModule, FmiVersion, Part

# Stepped one after the other in this order, each is given what the others put out at its sample.
PARTS = (Part.CONTROLLER, Part.MACHINE, Part.DEMAND)

OPEN = "external."  # what the names of inputs begin with that no unit here feeds


class Connection(NamedTuple):
    """From an output to an input of the same name."""

    start: Part
    end: Part
    name: str


def write_ssp(
    units: Mapping[Part, CModule],
    path: Path | str,
    *,
    stop_time: float,
    version: FmiVersion = FmiVersion.FMI2,
    platforms: Iterable[str] = (),
) -> Path:
    """Write the demand, the controller and the machine of a loop as FMUs, and how they are connected.

    Inputs for units of others, such as the machine's ``external.force``, are left without a connector.
    The same exports give the same bytes with the same compilers. The file is written whole or not at all.

    Args:
        units: the exports of the three parts.
        path: of the file, which ends in ".ssp".
        stop_time: of the default experiment [s]; a whole number of sample periods.
        version: of FMI.
        platforms: those that the FMUs hold binaries for, as of :func:`write_fmu`.

    Returns:
        The path written.

    Raises:
        ParameterError, HydroservoError: as of :func:`write_fmu`; and an input is no unit's output.

    Source: SSP 1.0, https://ssp-standard.org.
    Fails to say in which order a tool shall ask: one that reads all outputs before it sets any input delays
    each command by a period, whatever the dependencies in the FMUs say.
    """
    path = checked_ending(Path(path), ".ssp")
    chosen = platforms_named(platforms)
    content = {f"resources/{part}.fmu": fmu_of(units[part], stop_time, version, chosen) for part in PARTS}
    links = list(connections(units))
    ports = {part: connectors(part, units[part], links) for part in PARTS}
    context = {
        "units": {part: units[part] for part in PARTS},
        "connectors": ports,
        "base_units": base_units(one.unit for part in PARTS for one in ports[part]),
        "connections": links,
        "stop_time": stop_time,
    }
    content["SystemStructure.ssd"] = render("fmu/SystemStructure.xml", context).encode()
    with atomic_path(path) as temporary:
        pack(content, temporary)
    return path


def fmu_of(unit: CModule, stop_time: float, version: FmiVersion, platforms: Iterable[str]) -> bytes:
    packed = io.BytesIO()
    pack(fmu_content(unit, stop_time, version, platforms), packed)
    return packed.getvalue()


def connectors(part: Part, unit: CModule, links: Iterable[Connection]) -> list[FmiVariable]:
    """The outputs of an FMU and its inputs that are connected: a tool may connect any other as it likes."""
    fed = {link.name for link in links if link.end is part}
    return [one for one in variables_of(unit) if one.kind is VariableKind.OUTPUT or one.name in fed]


def base_units(names: Iterable[str]) -> dict[str, Mapping[str, int | float]]:
    """By its name each unit that SSP can say in terms of base units."""
    bases = {name: base_unit(name) for name in names if name}
    return {name: base for name, base in bases.items() if base is not None}


def connections(units: Mapping[Part, CModule]) -> Iterator[Connection]:
    """From each output to the inputs of other units that have its name."""
    variables = {part: variables_of(units[part]) for part in PARTS}
    outputs = {one.name: part for part in PARTS for one in variables[part] if one.kind is VariableKind.OUTPUT}
    for part in PARTS:
        for one in variables[part]:
            if one.kind is not VariableKind.INPUT or one.name.startswith(OPEN):
                continue
            if one.name not in outputs:
                raise HydroservoError(f"the input {one.name} of the {part} is not an output of another unit")
            yield Connection(outputs[one.name], part, one.name)
