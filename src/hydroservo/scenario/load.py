"""A loop from a scenario."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hydroservo.block import Block, field_at, leaves, value_at
from hydroservo.checks import consistent
from hydroservo.errors import ParameterError, ScenarioError
from hydroservo.hooks import at_rest
from hydroservo.loop import Loop
from hydroservo.nearest import one_of
from hydroservo.plants.design_model import DesignModel
from hydroservo.scenario.build import Argument, Draft, draft, hints
from hydroservo.scenario.layers import layered
from hydroservo.scenario.plugins import load_plugin
from hydroservo.scenario.registry import names_in_role
from hydroservo.scenario.search import Search, tune_search
from hydroservo.scenario.tables import Table
from hydroservo.scenario.uncertainty import Deviations, deviations

__all__ = ["Assembly", "Machine", "assembled", "load_scenario", "model_path", "with_nominal"]

DIGITAL = tuple(name for name in Loop._fields if name not in ("plant", "valve", "supply", "load", "nominal"))


class Machine(NamedTuple):
    """What uncertainty is about."""

    plant: Block
    valve: Block
    supply: Block
    load: Block


class Assembly(NamedTuple):
    """A loop, and what it was made of."""

    loop: Loop
    drafts: Mapping[str, Draft]  # by field of the loop, those of the machine before uncertainty
    deviations: Deviations
    arguments: Mapping[str, Argument]  # of constructors, by the path that changes take, before uncertainty
    search: Search  # of the loop's numbers


def load_scenario(
    source: str | Path, changes: Mapping[str, object] | None = None, plugins: Sequence[str | Path] = ()
) -> Loop:
    """The loop that a scenario describes.

    A scenario is a TOML file with a table for each field of :class:`~hydroservo.loop.Loop` but ``nominal``,
    tables in them for nested blocks, ``[uncertainty]``, and ``[tune]`` for the search of its numbers. With
    ``base = "rig/1khz"`` or the path of a file it builds on another: what it gives lies over that one's,
    key by key, and another ``type`` drops what the new one does not have. What neither gives takes the
    blocks' defaults; only the type of the controller must be there. The controller believes in the machine
    before its uncertainty, unless its own tables (``[controller.model.plant]`` ...) say otherwise. An
    uncertainty is a relative deviation of a parameter of the machine, or of what a constructor takes that its
    ``type`` names.

    Args:
        source: the path of a TOML file, or the name of a built-in scenario such as ``paper/sine-tsmc``.
        changes: values by dotted path, such as ``{"plant.mass": "7 kg"}``, that override those of the files;
            another ``type`` for a table drops what the files give in it, and of its uncertainty, and the new
            type does not have.
        plugins: Python files whose NamedTuple classes ``type`` may name; they are executed.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
    """
    return assembled(source, changes, plugins).loop


def assembled(
    source: str | Path, changes: Mapping[str, object] | None = None, plugins: Sequence[str | Path] = ()
) -> Assembly:
    """What :func:`load_scenario` returns, with what it was made of.

    Raises:
        ScenarioError: as there.
    """
    for plugin in plugins:
        load_plugin(plugin)
    scenario = layered(source, changes or {})
    check_tables(scenario)
    drafts = {name: part(scenario, name, None) for name in Machine._fields}
    machine = Machine(**{name: one.made() for name, one in drafts.items()})
    nominal = nominal_model(machine, scenario)
    drafts |= {name: part(scenario, name, nominal) for name in DIGITAL}
    digital = {name: drafts[name].made() for name in DIGITAL}
    digital["sensors"] = informed(digital["sensors"], scenario.table("sensors"), machine.plant)
    uncertainty = scenario.table("uncertainty")
    arguments = arguments_of(drafts, machine)
    given = deviations(scenario, machine, arguments)
    true_machine = perturbed(machine, drafts, arguments, given, uncertainty)
    check_true(true_machine, uncertainty)
    loop = Loop(**true_machine._asdict(), **digital, nominal=nominal)
    model = model_path(loop.controller)
    loop = loop if model is None else loop._replace(nominal=value_at(loop, model))
    return Assembly(loop, drafts, given, arguments, tune_search(scenario, loop, arguments))


def arguments_of(drafts: Mapping[str, Draft], machine: Machine) -> dict[str, Argument]:
    """What the constructors of a scenario take.

    Deviations of the machine are those of the block's own number, where it has one of the same name.
    """
    found = {path: one for name, block in drafts.items() for path, one in block.arguments(f"{name}.")}
    numbers = ((path, value) for path, value in leaves(machine) if isinstance(value, float))
    own = {path for path, value in numbers if value not in (0.0, field_at(machine, path).auto)}
    return {path: one for path, one in found.items() if path not in own}


def perturbed(
    machine: Machine,
    drafts: Mapping[str, Draft],
    arguments: Mapping[str, Argument],
    given: Deviations,
    uncertainty: Table,
) -> Machine:
    """The machine after its uncertainty: first that of what constructors take, then of its own numbers."""
    blocks = machine._asdict()
    for name in Machine._fields:
        taken = given.taken(name, arguments)
        try:
            block = drafts[name].replaced(taken).made() if taken else blocks[name]
        except ScenarioError as error:
            raise uncertainty.error(f"leads to {error.key}: {error.problem}") from None
        blocks[name] = given.perturbed(block, name)
    return Machine(**blocks)


def informed(sensors: Block, table: Table, plant: Block) -> Block:
    """Sensors that know the cylinder's areas, where a scenario does not give them others."""
    if hasattr(sensors, "sensors"):  # around others
        return sensors._replace(sensors=informed(sensors.sensors, table.table("sensors"), plant))
    area = getattr(plant, "piston_area", None)
    known = {name: getattr(plant, name, area) for name in ("area_a", "area_b")}
    missing = {name: area for name, area in known.items() if name in sensors._fields and not table.has(name)}
    return sensors._replace(**{name: area for name, area in missing.items() if area is not None})


def check_true(machine: Machine, uncertainty: Table) -> None:
    """Refuse a machine whose numbers do not go together after their uncertainty."""
    try:
        consistent(machine)
        at_rest(machine.plant, machine.supply, machine.load)
    except ParameterError as error:
        raise uncertainty.error(f"leads to {error}") from None


def model_path(controller: Block, path: str = "controller") -> str | None:
    """Where a controller's own model is, such as ``controller.model``; None if it has none.

    In wrappers it is that of the outermost law that has one: ``controller.controller.model``.
    """
    if isinstance(getattr(controller, "model", None), DesignModel):
        return f"{path}.model"
    inner = getattr(controller, "controller", None)
    return None if inner is None else model_path(inner, f"{path}.controller")


def part(scenario: Table, name: str, nominal: DesignModel | None) -> Draft:
    """The block of one field of the loop, before it is made."""
    return draft(hints(Loop)[name], Loop._field_defaults[name], scenario.table(name), nominal)


def with_nominal(loop: Loop, path: str) -> list[str]:
    """What changes with a number: where a controller has a model, disturbances are defined against that."""
    model = model_path(loop.controller)
    if model is None or not path.startswith(f"{model}.") or value_at(loop, model) is not loop.nominal:
        return [path]
    return [path, f"nominal.{path.removeprefix(f'{model}.')}"]


def check_tables(scenario: Table) -> None:
    """Refuse tables that a scenario does not have, and a scenario without a controller."""
    allowed = ("title", *(name for name in Loop._fields if name != "nominal"), "uncertainty", "tune")
    for name in scenario.names():
        if name not in allowed:
            raise scenario.entry(name).unknown(name, allowed)
    if scenario.has("title") and not isinstance(scenario.entry("title").value, str):
        raise scenario.entry("title").error("must be a string")
    controller = scenario.table("controller")
    if not controller.has("type"):
        role = hints(Loop)["controller"]
        names = names_in_role(role)
        raise controller.error(f"a [controller] table with a type is needed; it {one_of('', names)}")


def nominal_model(machine: Machine, scenario: Table) -> DesignModel:
    """What a controller believes about a machine unless told otherwise: its parameters before uncertainty.

    Raises:
        ScenarioError: the valve does not say what a controller needs to know of it, or the machine cannot
            rest at its start or be simplified.
    """
    orifice, gain = (getattr(machine.valve, name, None) for name in ("orifice", "gain"))
    if not (orifice is not None and hasattr(orifice, "simplified") and isinstance(gain, float)):
        name = type(machine.valve).__name__
        needed = "a field gain (a float) and a field orifice, metering edges with simplified()"
        raise scenario.table("valve").error(f"{name} must have {needed}, for the controller's model of it")
    try:
        plant = at_rest(machine.plant, machine.supply, machine.load).simplified()
        found = DesignModel(plant, orifice.simplified(), machine.supply.simplified(), gain)
        consistent(found)
    except (ParameterError, ArithmeticError) as error:
        raise scenario.error(str(error)) from None
    return found
