"""Tables whose ``type`` is "FMU": a load or a machine that others wrote."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.block import Block
from hydroservo.core.errors import HydroservoError, ScenarioError, nearest, short
from hydroservo.core.roles import Load, Plant
from hydroservo.cosimulation import (
    LOAD_INPUTS,
    LOAD_OUTPUTS,
    MACHINE_INPUTS,
    MACHINE_OUTPUTS,
    ForeignLoad,
    ForeignMachine,
)
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
from hydroservo.scenario.quantities import si_value, unit_factor
from hydroservo.scenario.tables import LayeredTable, TableEntry

FMU = "FMU"
KEYS = ("file", "signals", "parameters")
WITH_UNIT = re.compile(r"(.*\S)\s+\[([^][]*)\]")
ELEMENT = re.compile(r"(.*)\[([1-9][0-9]{0,5})\]")
SETTABLE = ("parameter", "structuralParameter", "input")
ANSWERED = ("output", "local", "calculatedParameter")

allowed_digests: set[str] = set()  # digests of the FMUs that the user, and no scenario, allowed to run


class RoleSignals(NamedTuple):
    """The signals of a role, each with its SI unit, and other names that variables may have for them."""

    block: Any  # the class that has no FMU yet
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    others: Mapping[str, str]


SIGNALS = {
    Load: RoleSignals(ForeignLoad, LOAD_INPUTS, LOAD_OUTPUTS, {}),
    Plant: RoleSignals(
        ForeignMachine,
        MACHINE_INPUTS,
        MACHINE_OUTPUTS,
        {"command": "controller.u"} | {name: f"measurement.{name}" for name in MACHINE_OUTPUTS},
    ),
}


def allow_fmu(path: Path) -> None:
    """Allow scenarios to name an FMU, whose native code then runs; as for a plug-in, only the user can."""
    try:
        allowed_digests.add(read_fmu(path.resolve()).digest)
    except HydroservoError as error:
        raise ScenarioError(str(path), "", str(error)) from None


def names_fmu(hint: Any, table: LayeredTable) -> bool:
    """Whether a table is that of an FMU in a role that one can have."""
    return hint in SIGNALS and table.has("type") and table.entry("type").value == FMU


def own_keys(role: Any) -> tuple[str, ...]:
    """The keys that the table of an FMU in a role has besides those of all."""
    return tuple(name for name in SIGNALS[role].block._fields if name != "held")


def fmu_class(role: Any, table: LayeredTable) -> type[Block]:
    if not table.has("file"):
        raise table.error('a file is needed: file = "machine.fmu"')
    entry, signals = table.entry("file"), SIGNALS[role]
    fmu = allowed_fmu(entry)
    named = table.table("signals")
    named.check_keys({**signals.inputs, **signals.outputs})
    inputs, outputs = (
        tuple(wires_of_side(fmu, named, side, signals.others, kinds))
        for side, kinds in ((signals.inputs, ("input",)), (signals.outputs, ANSWERED))
    )
    check_wires(fmu, table, inputs, outputs, signals)
    given = tuple(fmu_parameters(fmu, table.table("parameters"), {wire.variable for wire in inputs}))
    found: type[Block] = fmu_block_class(signals.block, Foreign(fmu, inputs, outputs, given))
    return found


def allowed_fmu(entry: TableEntry) -> Fmu:
    """The FMU that a scenario's ``file`` names."""
    if not isinstance(entry.value, str):
        raise entry.error("must be a string, the name of a file")
    path = (entry.origin.folder / entry.value).resolve()
    if not path.is_file():
        raise entry.error(f"there is no such file in {short(str(entry.origin.folder.absolute()))}")
    try:
        if digest_of(path) in allowed_digests:
            return read_fmu(path)
    except HydroservoError as error:
        raise entry.error(str(error)) from None
    raise entry.error(
        "is native code, which no scenario runs by itself; allow it: --plugin FILE, in Python plugins=[FILE]"
    )


def check_wires(
    fmu: Fmu, table: LayeredTable, inputs: Sequence[Wire], outputs: Sequence[Wire], signals: RoleSignals
) -> None:
    """Refuse an FMU of which nothing is used, or that is given nothing."""
    there = [one.name for one in fmu.variables.values() if one.causality == "input" and one.is_real]
    if not inputs and there:
        names = " or signals.".join(signals.inputs)
        raise table.error(f"name an input of the FMU in signals.{names}; it has {', '.join(there[:8])}")
    needed = [name for name in ("force",) if signals.block is ForeignLoad] or ["velocity", "position"]
    if not any(wire.signal in needed for wire in outputs):
        there = [one.name for one in fmu.variables.values() if one.causality == "output" and one.is_real]
        names = " or signals.".join(needed)
        raise table.error(f"name an output of the FMU in signals.{names}; it has {', '.join(there[:8])}")


def wires_of_side(
    fmu: Fmu, named: LayeredTable, side: Mapping[str, str], others: Mapping[str, str], kinds: Sequence[str]
) -> Iterator[Wire]:
    """The wires of one side: those that are named, and those whose variables have the signals' own names."""
    for signal, unit in side.items():
        if named.has(signal):
            yield named_wire(fmu, named.entry(signal), signal, unit, kinds)
            continue
        if (
            signal == "external_force"
        ):  # a machine of one's own has its load inside: adding another is asked for
            continue
        for name in (signal, others.get(signal, signal)):
            variable = fmu.variables.get(name)
            if variable is not None and variable.causality in kinds and variable.is_real:
                entry = TableEntry(named.origin, named.key(signal), name)
                yield Wire(signal, name, 0, wire_factor(variable, "", unit, entry))
                break


def named_wire(fmu: Fmu, entry: TableEntry, signal: str, unit: str, kinds: Sequence[str]) -> Wire:
    """The wire of a signal to "x", "x [mm]" or "x[2]"."""
    if not isinstance(entry.value, str):
        raise entry.error("must be a string, the name of a variable of the FMU")
    match = WITH_UNIT.fullmatch(entry.value.strip())
    name, given = (match[1], match[2].strip()) if match else (entry.value.strip(), "")
    element = ELEMENT.fullmatch(name)
    place = 0
    if name not in fmu.variables and element is not None and element[1] in fmu.variables:
        name, place = element[1], int(element[2]) - 1
    if name not in fmu.variables:
        raise entry.error(f"is not a variable of the FMU{nearest(name, fmu.variables)}")
    variable = fmu.variables[name]
    if variable.causality not in kinds or not variable.is_real:
        wanted = "an input" if kinds == ("input",) else "an output"
        kind = f"{variable.causality} of type {variable.kind}"
        raise entry.error(f"must be {wanted} of real numbers, and is {kind}")
    return Wire(signal, name, place, wire_factor(variable, given, unit, entry))


def wire_factor(variable: FmuVariable, given: str, unit: str, entry: TableEntry) -> float:
    """How many of an SI unit one of a variable's unit is; 1 where nothing names one."""
    if given and variable.unit:
        raise entry.error(f"has the unit {variable.unit} in the FMU already; leave [{given}] out")
    try:
        if variable.in_base_units:
            base = "" if variable.in_base_units == "1" else variable.in_base_units
            return float(unit_factor(base, unit) * Fraction(variable.factor))
        text = given or variable.unit
        return float(unit_factor(text, unit)) if text else 1.0
    except ValueError as error:
        raise entry.error(f"is in {given or variable.unit} and {error}") from None


def fmu_parameters(fmu: Fmu, table: LayeredTable, wired: set[str]) -> Iterator[tuple[str, Parameter]]:
    """What a table of parameters gives, in the FMU's own units."""
    settable = [one.name for one in fmu.variables.values() if one.settable and one.causality in SETTABLE]
    for name, entry in table.entries():
        if name not in settable or name in wired:
            why = "is given by a signal" if name in wired else "is not a parameter of the FMU that can be set"
            raise entry.error(f"{why}{'' if name in wired else nearest(name, settable)}")
        yield (
            name,
            tuple(parameter_value(fmu.variables[name], value, entry) for value in flatten_list(entry.value)),
        )


def flatten_list(value: Any) -> list[Any]:
    """A number, or those of nested lists row by row."""
    return [one for part in value for one in flatten_list(part)] if isinstance(value, list) else [value]


def parameter_value(variable: FmuVariable, value: Any, entry: TableEntry) -> float | bool | str:
    """A number as a variable takes it."""
    if variable.kind == "String" and isinstance(value, str):
        return value
    if variable.kind == "Boolean" and isinstance(value, bool):
        return value
    if variable.is_real and isinstance(value, str) and variable.unit:
        return quantity_in_own_unit(variable, value, entry)
    whole = not variable.is_real and variable.kind not in ("String", "Boolean")
    number = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
    if variable.kind in ("String", "Boolean", "Binary", "Clock") or not number or not math.isfinite(value):
        raise entry.error(f"must be of the FMU's type {variable.kind}")
    return value if whole else float(value)


def quantity_in_own_unit(variable: FmuVariable, value: str, entry: TableEntry) -> float:
    """A quantity such as "2 kN/m" in a variable's own unit."""
    base = "" if variable.in_base_units == "1" else variable.in_base_units or variable.unit
    try:
        return si_value(value, base) / (variable.factor if variable.in_base_units else 1.0)
    except ValueError as error:
        raise entry.error(f"{error} [{variable.unit}]") from None
