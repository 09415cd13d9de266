"""The machine's parameters moved away from their nominal values."""

from collections.abc import Callable, Iterator

from hydroservo.block import Block, leaves, replace, value_at
from hydroservo.checks import allowed, within
from hydroservo.field import Field, declared_fields
from hydroservo.scenario.build import number_from
from hydroservo.scenario.tables import Entry, Table

__all__ = ["perturbed"]

SCALE = Field("", "factor on all relative deviations")
RELATIVE = Field("", "relative deviation of a parameter")
UNDECLARED = Field("", "a number without a declaration")


def perturbed(machine: Block, table: Table, retyped: Callable[[str], bool]) -> Block:
    """A machine whose named parameters are multiplied by 1 + scale times their relative deviation.

    Args:
        machine: the blocks of the machine, as one block.
        table: ``scale`` (1 if not given), and a deviation for each path of a parameter.
        retyped: says of a path whether a block along it has another type than in the file. What the file
            gives of one that is then no parameter any more does not count.

    Raises:
        ScenarioError: a path of no parameter, or a deviation that is no number or leads out of range.
    """
    scale = number_from(table.entry("scale"), SCALE, float) if table.has("scale") else 1.0
    known = [path for path, value in leaves(machine) if isinstance(value, float)]
    changes = {}
    for path, entry in entries(table, ""):
        if path not in known and entry.origin is table.origin and retyped(path):
            continue
        if path not in known:
            raise entry.unknown(path, known)
        relative = number_from(entry, RELATIVE, float)
        nominal = value_at(machine, path)
        parent, _, name = path.rpartition(".")
        field = declared_fields(value_at(machine, parent).__class__).get(name, UNDECLARED)
        if nominal == field.auto:
            raise entry.error(f'deviates from {path} = "auto"; give that a value')
        value = nominal * (1.0 + scale * relative)
        if not within(value, field):
            raise entry.error(f"with scale {scale:g} makes {path} {value:g}; it must be {allowed(field)}")
        changes[path] = value
    return replace(machine, changes)


def entries(table: Table, prefix: str) -> Iterator[tuple[str, Entry]]:
    """The deviations with the paths of their parameters."""
    for name in table.names():
        if prefix or name != "scale":
            entry = table.entry(name)
            if isinstance(entry.value, dict):
                yield from entries(table.table(name), f"{prefix}{name}.")
            else:
                yield prefix + name, entry
