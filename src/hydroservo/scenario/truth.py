"""What a machine truly is: its nominal values, how far it deviates from them, and what is known outright."""

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from hydroservo.block import Block, field_at, leaves, replace, value_at
from hydroservo.field import Field
from hydroservo.scenario.build import Argument, number_from
from hydroservo.scenario.tables import Entry, Table
from hydroservo.validation import allowed, within

SCALE = Field("", "factor on all relative deviations")
RELATIVE = Field("", "relative deviation of a parameter")


class Deviation(NamedTuple):
    """How far a parameter is from its nominal value."""

    entry: Entry
    scale: float
    relative: float

    def of(self, path: str, nominal: float, field: Field) -> float:
        """The nominal value times 1 + scale times the relative deviation.

        Raises:
            ScenarioError: there is none of an automatic value, or it is out of the field's range.
        """
        if nominal == field.auto:
            raise self.entry.error(f'deviates from {path} = "auto"; give that a value')
        value = nominal * (1.0 + self.scale * self.relative)
        if not within(value, field):
            problem = f"with scale {self.scale:g} makes {path} {value:g}; it must be {allowed(field)}"
            raise self.entry.error(problem)
        return value


class Value(NamedTuple):
    """What a parameter is, whatever its nominal value."""

    value: float

    def of(self, path: str, nominal: float, field: Field) -> float:
        """The value itself."""
        return self.value


class Truth(NamedTuple):
    """What ``[uncertainty]`` and ``[truth]`` say of a machine."""

    arguments: Mapping[str, Deviation | Value]  # of what constructors take, by path
    numbers: Mapping[str, Deviation | Value]  # of the blocks' own parameters, by path

    def taken(self, name: str, arguments: Mapping[str, Argument]) -> dict[str, float]:
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


def truth_of(scenario: Table, machine: Block, arguments: Mapping[str, Argument]) -> Truth:
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
    of_arguments: dict[str, Deviation | Value] = {}
    of_numbers: dict[str, Deviation | Value] = {}
    for path, entry in checked_entries(table, known, scenario, but=("scale",)):
        one = Deviation(entry, scale, number_from(entry, RELATIVE, float))
        (of_numbers if path in numbers else of_arguments)[path] = one
    for path, entry in checked_entries(scenario.table("truth"), known, scenario):
        field = arguments[path].field if path in arguments else field_at(machine, path)
        value = Value(number_from(entry, field, float))
        (of_arguments if path in arguments else of_numbers)[path] = value
    return Truth(of_arguments, of_numbers)


def checked_entries(
    table: Table, known: Collection[str], scenario: Table, but: Collection[str] = ()
) -> Iterator[tuple[str, Entry]]:
    """What a table says of parameters, with their paths, but for some keys of its own."""
    for path, entry in table.entries():
        if path in known:
            yield path, entry
        elif path not in but and not scenario.has_type_above(entry.origin, path):
            raise entry.unknown(path, known)
