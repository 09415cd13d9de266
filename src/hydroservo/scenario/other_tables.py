"""The tables of a scenario that describe no block: start, metrics, commands, logs, uncertainty and truth."""

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import usual
from hydroservo.control.monitors.group import Usual, is_name
from hydroservo.core.block import Block, field_at, leaves, replace, state_field_at, value_at
from hydroservo.core.command_scale import FULL, VOLTS, CommandScale
from hydroservo.core.field import Field
from hydroservo.core.group import group, nested
from hydroservo.core.roles import Monitor, Start
from hydroservo.core.validation import allowed, within
from hydroservo.machine.starts import AsBuilt
from hydroservo.scenario.build import ConstructorArgument, Context, draft_block, number_from
from hydroservo.scenario.quantities import si_value
from hydroservo.scenario.records.columns import column_source
from hydroservo.scenario.records.series import sample_period
from hydroservo.scenario.tables import Layer, LayeredTable, TableEntry

GIVEN = "given"
STEADY = "steady"

USUAL = "usual"
FULL_SCALE = "full_scale"
ALLOWED = f'must be what {FULL} V of command stand for: a current such as "40 mA", "100 %" or "{FULL} V"'
COLUMNS, VARY = KEYS = "columns", "vary"
SCALE = Field("", "factor on all relative deviations")
RELATIVE = Field("", "relative deviation of a parameter")


def write_out_start(scenario: LayeredTable) -> LayeredTable:
    """A scenario with ``start = "steady"`` as the table that it stands for."""
    return scenario._replace(layers=tuple(map(write_out_layer, scenario.layers)))


def write_out_layer(layer: Layer) -> Layer:
    start = layer.given.get("start")
    if not isinstance(start, str):
        return layer
    if start != STEADY:
        raise TableEntry(layer.origin, "start", start).error(f'must be "{STEADY}", or a table')
    return layer._replace(given={**layer.given, "start": {"type": "Steady"}})


def start_in(table: LayeredTable, loop: Loop) -> Block:
    start = draft_block(Start, AsBuilt(), table.without(GIVEN)).made()
    entries = dict(table.table(GIVEN).entries())
    if not entries:
        return start
    state = loop.blocks_begin()
    known = [path for path, value in leaves(state) if isinstance(value, float)]
    numbers = {}
    for path, entry in entries.items():
        if path not in known:
            raise entry.unknown(path, known)
        numbers[path] = number_from(entry, state_field_at(loop, state, path), float)
    return start._replace(given=nested(numbers))


def metrics_in(table: LayeredTable, loop: Loop) -> Block:
    """The monitors that a table asks for: the usual ones, with those in it besides or in their place.

    One under a usual monitor's name takes its type and its place; ``usual = false`` leaves them out."""
    names = [name for name in table.names() if name != USUAL]
    if not table.names():
        return Usual()
    wanted = table.entry(USUAL).value if table.has(USUAL) else True
    if not isinstance(wanted, bool):
        raise table.entry(USUAL).error("must be true or false: whether the usual metrics count too")
    every, found = usual(loop), ({USUAL: Usual()} if wanted else {})
    context = Context(controlled=loop.controls.declared())
    for name in names:
        if not is_name(name):
            raise table.entry(name).error("must stand under a name of letters, digits and underscores")
        found[name] = draft_block(Monitor, every.get(name), table.table(name), context).made()
    return group(found)


def full_scale_in(table: LayeredTable) -> CommandScale:
    """What a table ``[command]`` says with ``full_scale = "40 mA"``; volts without one."""
    table.check_keys([FULL_SCALE])
    if not table.has(FULL_SCALE):
        return VOLTS
    entry = table.entry(FULL_SCALE)
    unit = full_scale_unit(entry.value)
    if unit is None:
        raise entry.error(ALLOWED)
    size = si_value(entry.value, unit)
    if size <= 0.0:
        raise entry.error("must be above 0")
    if unit == "V" and size != FULL:
        raise entry.error(ALLOWED)
    return {"A": CommandScale(current=size), "": CommandScale(share=size), "V": VOLTS}[unit]


def full_scale_unit(value: object) -> str | None:
    """The SI unit of a full scale, "" for one in %; None where it is none."""
    for unit in ("A", "V", ""):
        if isinstance(value, str) and (unit or value.rstrip().endswith("%")):
            try:
                si_value(value, unit)
            except ValueError:
                continue
            return unit
    return None


def log_columns(scenario: LayeredTable) -> dict[str, TableEntry]:
    """The columns of signals that the table names, as ``velocity = "v_piston [mm/s]"``, and the period."""
    table = scenario.table("identify")
    table.check_keys(KEYS)
    columns = table.table(COLUMNS)
    found = {name: columns.entry(name) for name in columns.names()}
    for name, entry in found.items():
        try:
            (sample_period if name == "period" else column_source)(entry.value)
        except ValueError as error:
            raise entry.error(str(error)) from None
    return found


def log_ranges(scenario: LayeredTable, loop: Loop, arguments: Collection[str]) -> dict[str, TableEntry]:
    """The ranges of the numbers that are sought, by path, such as ``plant.mass = "-40%..+70%"``.

    Those that a base gives for a block of another type than the loop's are left out.
    """
    entries = dict(scenario.table("identify").table(VARY).entries())
    known = {*arguments, *(path for path, _ in leaves(loop))}
    return {
        path: entry
        for path, entry in entries.items()
        if path in known or not scenario.has_type_above(entry.origin, path)
    }


class Deviation(NamedTuple):
    """How far a parameter is from its nominal value."""

    entry: TableEntry
    scale: float
    relative: float

    def of(self, path: str, nominal: float, field: Field) -> float:
        """The nominal value times 1 + scale times the relative deviation."""
        if nominal == field.auto:
            raise self.entry.error(f'deviates from {path} = "auto"; give that a value')
        value = nominal * (1.0 + self.scale * self.relative)
        if not within(value, field):
            problem = f"with scale {self.scale:g} makes {path} {value:g}; it must be {allowed(field)}"
            raise self.entry.error(problem)
        return value


class TrueValue(NamedTuple):
    """What a parameter is, whatever its nominal value."""

    value: float

    def of(self, path: str, nominal: float, field: Field) -> float:
        """The value itself."""
        return self.value


class Truth(NamedTuple):
    """What ``[uncertainty]`` and ``[truth]`` say of a machine."""

    arguments: Mapping[str, Deviation | TrueValue]  # of what constructors take, by path
    numbers: Mapping[str, Deviation | TrueValue]  # of the blocks' own parameters, by path

    def taken(self, name: str, arguments: Mapping[str, ConstructorArgument]) -> dict[str, float]:
        """What the constructors of a block of the machine take instead, by path in the block."""
        start = f"{name}."
        return {
            path.removeprefix(start): one.of(path, arguments[path].value, arguments[path].field)
            for path, one in self.arguments.items()
            if path.startswith(start)
        }

    def true(self, block: Block, name: str) -> Block:
        """A block of the machine with its own parameters as they truly are."""
        start = f"{name}."
        changes = {}
        for path, one in self.numbers.items():
            if path.startswith(start):
                inner = path.removeprefix(start)
                changes[inner] = one.of(path, value_at(block, inner), field_at(block, inner))
        return replace(block, changes)


def truth_of(scenario: LayeredTable, machine: Block, arguments: Mapping[str, ConstructorArgument]) -> Truth:
    """What the tables ``[uncertainty]`` and ``[truth]`` of a scenario give.

    ``[uncertainty]`` holds a ``scale`` (1 if not given), and a relative deviation for each path of a
    parameter; ``[truth]`` values in the parameter's unit, which count whatever deviates. What a layer gives
    of one that is no parameter any more, because a layer above gives a block along its path a type, does
    not count.
    """
    table = scenario.table("uncertainty")
    scale = number_from(table.entry("scale"), SCALE, float) if table.has("scale") else 1.0
    numbers = [path for path, value in leaves(machine) if isinstance(value, float)]
    known = (*numbers, *(path for path in arguments if path.partition(".")[0] in machine._fields))
    of_arguments: dict[str, Deviation | TrueValue] = {}
    of_numbers: dict[str, Deviation | TrueValue] = {}
    for path, entry in checked_entries(table, known, scenario, but=("scale",)):
        one = Deviation(entry, scale, number_from(entry, RELATIVE, float))
        (of_numbers if path in numbers else of_arguments)[path] = one
    for path, entry in checked_entries(scenario.table("truth"), known, scenario):
        field = arguments[path].field if path in arguments else field_at(machine, path)
        value = TrueValue(number_from(entry, field, float))
        (of_arguments if path in arguments else of_numbers)[path] = value
    return Truth(of_arguments, of_numbers)


def checked_entries(
    table: LayeredTable, known: Collection[str], scenario: LayeredTable, but: Collection[str] = ()
) -> Iterator[tuple[str, TableEntry]]:
    """What a table says of parameters, with their paths, but for some keys of its own."""
    for path, entry in table.entries():
        if path in known:
            yield path, entry
        elif path not in but and not scenario.has_type_above(entry.origin, path):
            raise entry.unknown(path, known)
