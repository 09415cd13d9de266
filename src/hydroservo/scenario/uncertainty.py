"""The machine's parameters moved away from their nominal values."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from hydroservo.block import Block, field_at, leaves, replace, value_at
from hydroservo.checks import allowed, within
from hydroservo.field import Field
from hydroservo.scenario.build import Argument, number_from
from hydroservo.scenario.tables import Entry, Table

__all__ = ["Deviation", "Deviations", "deviations"]

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


class Deviations(NamedTuple):
    """What ``[uncertainty]`` says of a machine."""

    arguments: Mapping[str, Deviation]  # of what constructors take, by path
    numbers: Mapping[str, Deviation]  # of the blocks' own parameters, by path

    def taken(self, name: str, arguments: Mapping[str, Argument]) -> dict[str, float]:
        """What the constructors of a block of the machine take instead, by path in the block.

        Args:
            name: which block of the machine it is.
            arguments: what they take before uncertainty, by path.

        Raises:
            ScenarioError: a deviation leads out of range.
        """
        start = f"{name}."
        return {
            path.removeprefix(start): one.of(path, arguments[path].value, arguments[path].field)
            for path, one in self.arguments.items()
            if path.startswith(start)
        }

    def perturbed(self, block: Block, name: str) -> Block:
        """A block of the machine with its own parameters moved away from their values.

        Args:
            block: the block, made of arguments that have their deviations.
            name: which block of the machine it is.

        Raises:
            ScenarioError: a deviation leads out of range.
        """
        start = f"{name}."
        changes = {}
        for path, one in self.numbers.items():
            if path.startswith(start):
                inner = path.removeprefix(start)
                changes[inner] = one.of(path, value_at(block, inner), field_at(block, inner))
        return replace(block, changes)


def deviations(scenario: Table, machine: Block, arguments: Mapping[str, Argument]) -> Deviations:
    """The deviations that the table ``[uncertainty]`` of a scenario gives.

    It holds a ``scale`` (1 if not given), and a deviation for each path of a parameter. What a layer gives
    of one that is no parameter any more, because a layer above gives a block along its path a type, does
    not count.

    Args:
        scenario: all its tables.
        machine: the blocks of the machine, as one block.
        arguments: what may deviate besides the numbers of the blocks.

    Raises:
        ScenarioError: a path of no parameter, or a deviation that is no number.
    """
    table = scenario.table("uncertainty")
    scale = number_from(table.entry("scale"), SCALE, float) if table.has("scale") else 1.0
    known = [path for path, value in leaves(machine) if isinstance(value, float)]
    of_arguments: dict[str, Deviation] = {}
    of_numbers: dict[str, Deviation] = {}
    for path, entry in entries(table, ""):
        if path not in known and path not in arguments:
            if scenario.has_type_above(entry.origin, path):
                continue
            raise entry.unknown(path, (*known, *arguments))
        one = Deviation(entry, scale, number_from(entry, RELATIVE, float))
        (of_numbers if path in known else of_arguments)[path] = one
    return Deviations(of_arguments, of_numbers)


def entries(table: Table, prefix: str) -> Iterator[tuple[str, Entry]]:
    """The deviations with the paths of their parameters."""
    for name in table.names():
        if prefix or name != "scale":
            entry = table.entry(name)
            if isinstance(entry.value, dict):
                yield from entries(table.table(name), f"{prefix}{name}.")
            else:
                yield prefix + name, entry
