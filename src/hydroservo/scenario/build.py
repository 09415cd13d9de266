"""Blocks from tables, and curves from files or points."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, cast

from hydroservo.control.controlled import Velocity
from hydroservo.core.block import Block, signal_below, signal_of
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.group import group
from hydroservo.core.roles.saying import is_role
from hydroservo.core.validation import allowed, checked, checked_number
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel
from hydroservo.scenario.fmus import FMU, KEYS, fmu_class, names_fmu, own_keys
from hydroservo.scenario.quantities import number_and_unit, si_value, unit_factor
from hydroservo.scenario.records.series import axis_key, read_curve
from hydroservo.scenario.registry import (
    Maker,
    defaults,
    is_block_class,
    is_of_plugin,
    maker_in_role,
    makers,
    names_in_role,
)
from hydroservo.scenario.role_checks import argument_types, check_maker
from hydroservo.scenario.tables import LayeredTable, TableEntry

FULL, POINTS = "full", "points"
LARGEST_INTEGER = 2**63  # TOML's integers have 64 bits
ROUNDED = 1e-12  # by which one length may differ from itself in two units
NO_FIELD = Field("", "")
VELOCITY = Velocity().declared()
SIGNALS = ("controls", "inner_controls")  # by which a block says what the units of its other numbers are of


def curve_from(table: LayeredTable, field: Field | None) -> Curve:
    """The curve that a table names a file of, or whose points it has.

    A file is read by :func:`~hydroservo.scenario.records.read_curve`; points are pairs of x and y, such as
    ``{points = [["0 m/s", "130 V/m"], ["0.25 m/s", "55 V/m"]]}``. Of a curve over a share, ``full = "10 V"``
    says what 100 % is where its axis has another unit.
    """
    if field is None or field.over or not table.has(FULL):
        return curve_from_points(table, field) if table.has(POINTS) else curve_from_file(table, field)
    entry = table.entry(FULL)
    try:
        size, unit = number_and_unit(entry.value if isinstance(entry.value, str) else "", "V")
        unit_factor(unit, None)
    except ValueError as error:
        raise entry.error(str(error)) from None
    if not size > 0.0:
        raise entry.error("must be above 0")
    found = curve_from(table.without(FULL), replace(field, over=unit))
    return Curve.from_samples(found.knots / float(size), found.samples)


def curve_from_file(table: LayeredTable, field: Field | None) -> Curve:
    if not table.has("file"):
        like = f'{{file = "curve.csv", column = "y", {axis_key(field)} = "x"}}'
        raise table.error(f"a file is needed, or points: {like}")
    return read_curve(table, field)


def curve_from_points(table: LayeredTable, field: Field | None) -> Curve:
    for name in table.names():
        if name != POINTS:
            raise table.entry(name).error(f"is given beside {table.key(POINTS)}; give only one of them")
    entry, declared = table.entry(POINTS), field or Field("", "", over="")
    if not isinstance(entry.value, list):
        raise entry.error(f"must be a list of pairs: {example_points(declared)}")
    pairs = [
        point_from(TableEntry(entry.origin, f"{entry.key}[{i}]", one), declared)
        for i, one in enumerate(entry.value)
    ]
    try:
        return Curve.from_samples([x for x, _ in pairs], [y for _, y in pairs])
    except ParameterError as error:
        raise entry.error(str(error)) from None


def point_from(entry: TableEntry, field: Field) -> tuple[float, float]:
    """A point, in the units of its declaration."""
    if not isinstance(entry.value, list) or len(entry.value) != 2:
        raise entry.error(f"must be a pair, as in {example_points(field)}")
    x, y = entry.value
    return coordinate(entry._replace(value=x), field.over), coordinate(entry._replace(value=y), field.unit)


def coordinate(entry: TableEntry, unit: str) -> float:
    """One number of a point, in a unit."""
    value: Any = entry.value
    if isinstance(value, str):
        try:
            return si_value(value, unit)
        except ValueError as error:
            raise entry.error(str(error)) from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise entry.error("must be a number, or one with a unit")
    return float(value)


def example_points(field: Field) -> str:
    """Two points as they are typed."""
    (x0, y0), (x1, y1) = ([f"{n} {unit}".strip() for unit in (field.over, field.unit)] for n in (0, 1))
    return f'[["{x0}", "{y0}"], ["{x1}", "{y1}"]]'


def no_model() -> None:
    """A model in a machine or a metric has nothing to start from."""


class Context(NamedTuple):
    """What a block's table is read with.

    Attributes:
        nominal: gives what a :class:`DesignModel` inside the block starts from for which there is a table.
        controlled: the signal that the loop controls, in whose unit some numbers are.
        of_result: whether the tables are those that a result carries: what a design computes is then
            in them, and computed again.
    """

    nominal: Callable[[], DesignModel | None] = no_model
    controlled: Field = VELOCITY
    of_result: bool = False

    def below(self, signals: Block, name: str) -> "Context":
        """The context of what has a name in a block, of which the signals that it says are known."""
        own = signal_of(signals, self.controlled)
        inside = signal_below(signals, name, own)
        return self if inside is None else self._replace(controlled=inside)


class ConstructorArgument(NamedTuple):
    """A number that a constructor takes."""

    field: Field
    value: float  # in SI units


class Draft(NamedTuple):
    """A block before it is made: what makes it, and of what."""

    maker: Maker
    members: Mapping[str, Any]  # the arguments: numbers, recorded signals, blocks and drafts of blocks
    table: LayeredTable  # where they come from

    def made(self) -> Block:
        """The block."""
        values = {name: one.made() if isinstance(one, Draft) else one for name, one in self.members.items()}
        try:
            check_rated(self.members)
            return checked(self.maker(**values))
        except (ParameterError, ArithmeticError) as error:
            raise self.table.error(str(error)) from None

    def replaced(self, numbers: Mapping[str, float]) -> "Draft":
        members = dict(self.members)
        for path, value in numbers.items():
            name, _, rest = path.partition(".")
            members[name] = members[name].replaced({rest: value}) if rest else value
        return self._replace(members=members)

    def open_at(self, paths: Collection[str]) -> "Draft":
        """The draft with those blocks in it made of which no number is at one of these paths."""
        members = dict(self.members)
        for name, one in members.items():
            if isinstance(one, Draft):
                start = f"{name}."
                own = [path.removeprefix(start) for path in paths if path.startswith(start)]
                members[name] = one.open_at(own) if own else one.made()
        return self._replace(members=members)

    def arguments(self, prefix: str = "") -> Iterator[tuple[str, ConstructorArgument]]:
        """Each float that a constructor takes, here or in a block, by its path after a prefix."""
        for name, one in self.members.items():
            if isinstance(one, Draft):
                yield from one.arguments(f"{prefix}{name}.")
            elif isinstance(one, float) and not isinstance(self.maker, type):
                field = declared_fields(self.maker).get(name, Field("", name))
                yield prefix + name, ConstructorArgument(field, one)


def check_rated(members: Mapping[str, Any]) -> None:
    """Refuse a valve whose edges are rated at an opening that its spool does not reach.

    Edges do not keep what they are made of, so nothing but the scenario's numbers can say so.
    """
    edges, reached = members.get("orifice"), members.get("max_opening")
    if not isinstance(edges, Draft) or not isinstance(reached, float):
        return
    rated = edges.members.get("rated_opening", 0.0)
    if rated > reached * (1.0 + ROUNDED):
        raise ParameterError("orifice.rated_opening", rated, f"must be at most max_opening, {reached:g} [m]")


def draft_block(
    hint: Any, default: Block | None, table: LayeredTable, context: Context | None = None
) -> Draft:
    """The block that a table describes, before it is made."""
    context = context or Context()
    if names_fmu(hint, table):
        return draft_fmu(hint, default, table, context)
    if hint is DesignModel:  # what a law believes, whatever its class believes by default
        default = context.nominal() if table.names() else THIS_MACHINE
    maker = maker_of(hint, default, table)
    if is_of_plugin(maker):
        check_maker(maker)
    base = default._asdict() if default is not None and type(default) is maker else defaults(maker)
    present = "" if default is None else type(default).__name__
    table = table.retyped(present, lambda entry: defaults(maker_named(hint, default, entry)))
    for name in table.names():
        if name not in (*base, "type"):
            raise table.entry(name).unknown(name, base, table.with_key(name))
    said = {name: member_value(maker, name, base[name], table, context) for name in base if name in SIGNALS}
    signals = group({name: one.made() if isinstance(one, Draft) else one for name, one in said.items()})
    others = {
        name: member_value(maker, name, base[name], table, context.below(signals, name))
        for name in base
        if name not in said
    }
    return Draft(maker, {name: (said | others)[name] for name in base}, table)


def draft_fmu(role: Any, default: Block | None, table: LayeredTable, context: Context) -> Draft:
    """The block of an FMU, before it is made."""
    present = "" if default is None else type(default).__name__
    keys = (*KEYS, *own_keys(role))
    table = table.retyped(
        present, lambda entry: keys if entry.value == FMU else defaults(maker_named(role, default, entry))
    )
    for name in table.names():
        if name not in (*keys, "type"):
            raise table.entry(name).unknown(name, keys)
    maker: Maker = fmu_class(role, table)
    members = {
        name: member_value(maker, name, value, table, context) for name, value in defaults(maker).items()
    }
    return Draft(maker, members, table)


def maker_of(hint: Any, default: Block | None, table: LayeredTable) -> Maker:
    """The class or constructor that a table's ``type`` names; without one, the class of the default."""
    if not table.has("type"):
        if default is not None:
            return type(default)
        if is_block_class(hint):
            return cast("Maker", hint)
        raise table.error(f"a type is needed; it {one_of('', type_names(hint))}")
    return maker_named(hint, default, table.entry("type"))


def maker_named(hint: Any, default: Block | None, entry: TableEntry) -> Maker:
    """The class or constructor that a ``type`` names."""
    if is_role(hint):
        return maker_in_role(hint, entry)
    cls: type = hint if is_block_class(hint) else type(default)
    found = makers(cls)
    if not isinstance(entry.value, str) or entry.value not in found:
        raise entry.error(f"must be {' or '.join(found)}")
    return found[entry.value]


def type_names(hint: Any) -> list[str]:
    return names_in_role(hint) if is_role(hint) else [getattr(hint, "__name__", str(hint))]


def member_value(maker: Maker, name: str, default: Any, table: LayeredTable, context: Context) -> Any:
    """The value of one argument: a draft of a block, a recorded signal or a number."""
    hint = argument_types(maker).get(name)
    declared = declared_fields(maker).get(name)
    field = (declared or NO_FIELD).of(context.controlled)
    if hint is Curve:
        optional = isinstance(default, Curve) and default.coefficients.any() and not table.has(name)
        return default if optional else curve_from(table.table(name), field if declared else None)
    if is_role(hint) or is_block_class(hint) or is_block_class(type(default)):
        return draft_block(hint, default, table.table(name), context)
    if table.has(name) and field.derived and not context.of_result:
        raise table.entry(name).error("is computed before a run; leave it out")
    if table.has(name) and not field.derived:
        return number_from(table.entry(name), field, hint)
    if default is None:
        raise table.error(f"{name} is missing; it {must_be(field, hint)}{table.beside_part()}")
    return number_from(TableEntry(table.origin, table.key(name), default), field, hint)


def number_from(entry: TableEntry, field: Field, kind: Any) -> float | int | bool:
    """A number of its declared kind, unit and range."""
    if kind not in (bool, int, float):
        raise entry.error("cannot be a block's parameter: that is a float, an int or a bool")
    automatic = isinstance(entry.value, str) and entry.value == "auto" and field.auto is not None
    value = field.auto if automatic else entry.value
    if isinstance(value, int) and abs(value) >= LARGEST_INTEGER:
        raise entry.error(must_be(field, kind))
    if kind is float and isinstance(value, str):
        try:
            value = si_value(value, field.unit)
        except ValueError as error:
            raise entry.error(f"{error}; it {must_be(field, kind)}") from None
    try:
        return checked_number(value, entry.key, field, kind)
    except ParameterError:
        raise entry.error(must_be(field, kind)) from None


def must_be(field: Field, kind: Any) -> str:
    return f"must be {'true or false' if kind is bool else allowed(field, kind is int)}"
