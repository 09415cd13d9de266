"""A loop from a scenario."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

from hydroservo.control.loop import Loop, Simulation
from hydroservo.control.wiring import believed, is_open, wired, with_model
from hydroservo.core.block import Block, field_at, leaves
from hydroservo.core.command_scale import command_scale, commands_in, note_command_scale
from hydroservo.core.errors import ParameterError, ScenarioError, one_of
from hydroservo.core.hooks import at_rest
from hydroservo.core.roles import Plant
from hydroservo.core.validation import consistent
from hydroservo.cosimulation import ForeignMachine, NoSupply, ThroughFmu
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.machine.valves.no_valve import NoValve
from hydroservo.runs.arguments import as_list, checked_mapping, checked_path
from hydroservo.scenario.build import ConstructorArgument, Context, Draft, draft_block
from hydroservo.scenario.fmus import names_fmu
from hydroservo.scenario.other_tables import (
    Truth,
    full_scale_in,
    log_columns,
    log_ranges,
    metrics_in,
    start_in,
    truth_of,
    write_out_start,
)
from hydroservo.scenario.registry import load_plugin, names_in_role
from hydroservo.scenario.role_checks import argument_types
from hydroservo.scenario.scenario_files import layered_table
from hydroservo.scenario.tables import LayeredTable, TableEntry
from hydroservo.scenario.tune_table import SearchSettings, tune_search

FIRST = ("plant", "valve", "supply", "drive", "load", "metrics", "controls", "start", "command")
INSIDE: Mapping[str, Block] = {"valve": NoValve(), "supply": NoSupply(), "drive": ThroughFmu()}  # of an FMU
DIGITAL = tuple(name for name in Loop._fields if name not in FIRST)


class MachineBlocks(NamedTuple):
    """What a scenario may say the truth of."""

    plant: Block
    valve: Block
    supply: Block
    drive: Block
    load: Block


class Assembly(NamedTuple):
    """A loop, and what it was made of."""

    loop: Loop
    nominal: MachineBlocks  # before its uncertainty and truth
    drafts: Mapping[str, Draft]  # by field of the loop, those of the nominal machine
    truth: Truth
    arguments: Mapping[
        str, ConstructorArgument
    ]  # of constructors, by the path that changes take, nominal ones
    search: SearchSettings  # of the loop's numbers
    log_columns: Mapping[str, TableEntry] = {}  # of a log, by the signal that they hold
    log_ranges: Mapping[str, TableEntry] = {}  # of what is sought in logs, by path
    title: str = ""  # its own, not that of its base


def load_scenario(
    source: str | Path, changes: Mapping[str, object] | None = None, plugins: Sequence[str | Path] = ()
) -> Loop:
    """The loop that a scenario describes.

    A scenario is a TOML file with a table for each field of :class:`~hydroservo.control.loop.Loop`, tables in
    them for nested blocks, ``[uncertainty]`` and ``[truth]``, ``[tune]`` for the search of its numbers and
    ``[identify]`` for its logs. With ``base = "rig/1khz"`` or the path of a file it builds on another: what
    it gives lies over that one's, key by key; another ``type`` drops what the new one does not have, and in
    ``[controller]`` all that the base gives, for gains of one law mean nothing to another. What neither gives
    takes the blocks' defaults; the types of plant, valve, supply, reference and controller must be there,
    here or in the base. The controller believes in the machine before its uncertainty and truth, unless its
    own tables (``[controller.model.plant]`` ...) say otherwise. An uncertainty is a relative deviation of a
    parameter of the machine, or of what a constructor takes that its ``type`` names; a truth is the value
    that such a number has, whatever deviates.

    Args:
        source: the path of a TOML file, or the name of a built-in scenario such as ``paper/sine-tsmc``.
        changes: values by dotted path, such as ``{"plant.mass": "7 kg"}``, that override those of the files;
            another ``type`` for a table drops what the files give in it, and of its uncertainty, and the new
            type does not have.
        plugins: Python files whose NamedTuple classes ``type`` may name; they are executed.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
        ParameterError: an argument is of another kind.
    """
    return assemble(source, changes, plugins).loop


def assemble(
    source: str | Path, changes: Mapping[str, object] | None = None, plugins: Sequence[str | Path] = ()
) -> Assembly:
    """What :func:`load_scenario` returns, with what it was made of.

    Raises:
        ScenarioError: as there.
    """
    given = checked_mapping("changes", {} if changes is None else changes, "paths to values")
    for plugin in as_list("plugins", plugins, "files, such as ['my_controller.py']"):
        load_plugin(checked_path("plugins", plugin))
    scenario = write_out_start(layered_table(source, given))
    check_scenario_tables(scenario)
    scale = full_scale_in(scenario.table("command"))
    with commands_in(scale):
        found = assemble_tables(scenario)
    note_command_scale(scale)
    return found


def assemble_tables(scenario: LayeredTable) -> Assembly:
    """The loop that tables describe, and what it is made of."""
    own = {} if not names_fmu(Plant, scenario.table("plant")) else INSIDE
    drafts = {name: draft_part(scenario, name, default=own.get(name)) for name in MachineBlocks._fields}
    machine = MachineBlocks(**{name: one.made() for name, one in drafts.items()})
    controls = draft_part(scenario, "controls").made()
    context = Context(partial(believed_machine, machine, scenario), controls.declared(), scenario.has("type"))
    drafts |= {name: draft_part(scenario, name, context) for name in DIGITAL}
    digital = {name: drafts[name].made() for name in DIGITAL}
    with errors_name_tables(scenario):
        blocks = Loop(**machine._asdict(), **digital, controls=controls, command=command_scale())
        loop = wired(drop_blocks_inside_fmu(blocks))
    loop = loop._replace(metrics=metrics_in(scenario.table("metrics"), loop))
    loop = loop._replace(start=start_in(scenario.table("start"), loop))
    arguments = arguments_of(drafts, machine)
    truth = truth_of(scenario, machine, arguments)
    loop = drop_blocks_inside_fmu(true_machine(scenario, loop, machine, drafts, arguments, truth))
    search = tune_search(scenario, loop, arguments)
    ranges = log_ranges(scenario, loop, arguments)
    columns, tables = log_columns(scenario), [one.given for one in scenario.layers[:2]]
    title = next((str(one["title"]) for one in tables if "title" in one), "")
    return Assembly(loop, machine, drafts, truth, arguments, search, columns, ranges, title)


def drop_blocks_inside_fmu(loop: Loop) -> Loop:
    """A loop whose machine is an FMU without valve, supply and drive beside it, which its law alone knows."""
    if not isinstance(loop.plant, ForeignMachine):
        return loop
    controller = with_model(loop.controller, believed(loop)) if is_open(loop.controller) else loop.controller
    return loop._replace(controller=controller, **INSIDE)


def arguments_of(drafts: Mapping[str, Draft], machine: MachineBlocks) -> dict[str, ConstructorArgument]:
    """What the constructors of a scenario take.

    Deviations of the machine are those of the block's own number, where it has one of the same name.
    """
    found = {path: one for name, block in drafts.items() for path, one in block.arguments(f"{name}.")}
    numbers = ((path, value) for path, value in leaves(machine) if isinstance(value, float))
    own = {path for path, value in numbers if value not in (0.0, field_at(machine, path).auto)}
    return {path: one for path, one in found.items() if path not in own}


def true_machine(
    scenario: LayeredTable,
    loop: Loop,
    machine: MachineBlocks,
    drafts: Mapping[str, Draft],
    arguments: Mapping[str, ConstructorArgument],
    truth: Truth,
) -> Loop:
    """The loop with the machine as it truly is: first what constructors take, then its own numbers."""
    blocks = machine._asdict()
    for name in MachineBlocks._fields:
        taken = truth.taken(name, arguments)
        try:
            block = drafts[name].replaced(taken).made() if taken else blocks[name]
        except ScenarioError as error:
            raise truth_error(scenario, f"{error.key}: {error.problem}") from None
        blocks[name] = truth.true(block, name)
    true = loop._replace(**blocks)
    try:
        consistent(MachineBlocks(**blocks))
        at_rest(true)
    except ParameterError as error:
        raise truth_error(scenario, str(error)) from None
    return true


def truth_error(scenario: LayeredTable, problem: str) -> ScenarioError:
    """An error about a machine whose true numbers do not go together."""
    uncertainty, truth = scenario.table("uncertainty"), scenario.table("truth")
    if not (truth.names() or uncertainty.names()):
        return scenario.error(problem)
    if not truth.names():
        return uncertainty.error(f"leads to {problem}")
    return truth.error(f"{'and uncertainty lead' if uncertainty.names() else 'leads'} to {problem}")


def draft_part(
    scenario: LayeredTable, name: str, context: Context | None = None, default: Block | None = None
) -> Draft:
    """The block of one field of the loop, before it is made."""
    default = default or Loop._field_defaults.get(name)
    return draft_block(argument_types(Loop)[name], default, scenario.table(name), context)


def check_scenario_tables(scenario: LayeredTable) -> None:
    """Refuse tables that a scenario does not have, and one that lacks a block without default."""
    allowed = ("title", *Loop._fields, "uncertainty", "truth", "tune", "identify")
    for name in scenario.names():
        if name == "type" and scenario.entry(name).value == Loop.__name__:
            continue  # of the scenario that a result carries
        if name not in allowed:
            raise scenario.entry(name).unknown(name, allowed)
    if scenario.has("title") and not isinstance(scenario.entry("title").value, str):
        raise scenario.entry("title").error("must be a string")
    for name, role in argument_types(Loop).items():
        table = scenario.table(name)
        inside = name in INSIDE and names_fmu(Plant, scenario.table("plant"))
        open_ = name not in Loop._field_defaults and role is not Simulation
        if open_ and not inside and not table.has("type"):
            names = names_in_role(role)
            raise table.error(f"a [{name}] table with a type is needed, or a base; it {one_of('', names)}")


def believed_machine(machine: MachineBlocks, scenario: LayeredTable) -> DesignModel:
    """What a law believes of a machine unless told otherwise: its nominal parameters."""
    with errors_name_tables(scenario):
        return believed(machine)


@contextmanager
def errors_name_tables(scenario: LayeredTable) -> Iterator[None]:
    """Errors of wiring are those of the table that they are about."""
    try:
        yield
    except ParameterError as error:
        name = error.path.partition(".")[0]
        table = scenario.table(name) if name in Loop._fields else scenario
        text = f"{error.value} {error.allowed}" if error.path == name else str(error)
        raise table.error(text) from None
    except ArithmeticError as error:
        raise scenario.error(str(error)) from None
