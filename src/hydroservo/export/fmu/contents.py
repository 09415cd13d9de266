"""The texts in an FMU: description, sources, documentation."""

import hashlib
import uuid
from collections.abc import Mapping
from importlib import resources
from typing import Any

from hydroservo.export.c.compiler import BITS
from hydroservo.export.fmu.headers import headers, licence
from hydroservo.export.fmu.interface import Interface, interface_of
from hydroservo.export.fmu.structure import structure_of
from hydroservo.export.fmu.units import base_unit
from hydroservo.export.fmu.variables import Kind, clock_after, variables_of
from hydroservo.export.render import rendered
from hydroservo.export.unit import FmiVersion, Part, Unit

Files = dict[str, str]
"""Texts by their path in the FMU."""


def fmu_files(unit: Unit, stop_time: float, version: FmiVersion, clocked: bool = False) -> Files:
    """All but the binary.

    The token that ties the description to the sources is a digest of both, so that equal exports have equal
    tokens and others have others.

    Raises:
        ParameterError: a name cannot be that of a variable, or it cannot have a clock.
        HydroservoError: the package fmpy is missing.
    """
    interface = interface_of(version, unit.part, clocked)
    context = context_of(unit, stop_time, version, interface)
    plain = model_files(unit, interface, {**context, "token": ""})
    digest = hashlib.sha256("\0".join(part for one in sorted(plain.items()) for part in one).encode())
    token = str(uuid.UUID(digest.hexdigest()[:32]))
    files = model_files(unit, interface, {**context, "token": token})
    own = {f"sources/include/{name}": text for name, text in headers(interface.headers).items()}
    return files | documentation(context) | own


def context_of(unit: Unit, stop_time: float, version: FmiVersion, interface: Interface) -> dict[str, Any]:
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
        "integrated": [one for one in variables if one.kind is Kind.INTEGRATED],
        "rates": [one for one in variables if one.kind is Kind.RATE],
        "units": {one.unit: base_unit(one.unit) for one in variables if one.unit},
        "sources": [f"{unit.prefix}.c", "model.c", *interface.sources],
        "options": BITS,
        "parameters": ", &numbers->parameters" if unit.parameters else "",
    }


def model_files(unit: Unit, interface: Interface, context: Mapping[str, Any]) -> Files:
    """The model description and the sources."""
    folder = resources.files("hydroservo.export.fmu") / "sources"
    own = (*interface.sources, *interface.own_headers)
    return {
        "modelDescription.xml": rendered(interface.description, context),
        f"sources/{unit.prefix}.h": unit.header,
        f"sources/{unit.prefix}.c": unit.source,
        "sources/model.h": rendered("fmu/model.h", context),
        "sources/model.c": rendered("fmu/model.c", context),
        **{path: rendered(template, context) for path, template in interface.texts.items()},
        **{f"sources/{name}": (folder / name).read_text("utf-8") for name in own},
    }


def documentation(context: Mapping[str, Any]) -> Files:
    return {
        "documentation/index.html": rendered("fmu/index.html", context),
        "documentation/scenario.toml": context["unit"].scenario,
        "documentation/licenses/license.txt": rendered("fmu/license.txt", {"own": licence("hydroservo")}),
        "documentation/licenses/fmpy.txt": licence("fmpy"),
    }
