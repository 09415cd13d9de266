"""Random parameters, states and inputs for every block."""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from hydroservo.block import Block, is_block, leaves, replace
from hydroservo.checks import consistent, in_range, within
from hydroservo.errors import ParameterError
from hydroservo.field import Field, declared_fields
from hydroservo.holds import HeldTwice
from hydroservo.plants import DesignModel
from hydroservo.roles import Reaching, Realisation
from hydroservo.scenario.fits import ROLES
from hydroservo.signals import Demand, Draws, MachineOutputs, Measurement, PortFlows, Pressures
from hydroservo.time_series import TimeSeries
from hydroservo.valves import Orifice
from roles import NOTHING, playing, wraps


class Range(NamedTuple):
    """How far from a block's defaults its parameters may be.

    Attributes:
        decades: number of powers of ten to either side.
        margin: share of a range bounded at both sides that is left out at each end.
    """

    decades: float
    margin: float


ORDINARY = Range(1.0, 0.2)
WIDE = Range(4.0, 0.0)


def block_of(cls: type, spread: Range) -> SearchStrategy[Block]:
    """Blocks of a class with random parameters in their ranges; nested blocks keep their default type."""
    if cls is TimeSeries:
        return series()
    defaults = cls()
    fields = declared_fields(cls)
    parts = {
        name: block_of(type(value), spread)
        if is_block(value)
        else number(value, fields.get(name, Field("", name)), spread)
        for name, value in zip(cls._fields, defaults, strict=True)
    }
    return st.builds(cls, **parts).map(in_range)


def wired(cls: type, spread: Range) -> SearchStrategy[Block]:
    """Blocks of a class, each nested block of any type that plays its role."""
    hints = get_type_hints(cls)
    inner = {
        name: st.one_of([wired(choice, spread) for choice in choices(cls, hints[name])])
        for name in cls._fields
        if hints[name] in ROLES
    }
    exchanged = st.fixed_dictionaries(inner)
    return st.builds(going_together, block_of(cls, spread), exchanged)


def going_together(block: Block, parts: dict[str, Block]) -> Block:
    """A block with these parts, or with numbers or parts of its defaults where those do not go together."""
    default = type(block)()
    for candidate in (replace(block, parts), replace(default, parts)):
        try:
            consistent(candidate)
        except ParameterError:
            continue
        return candidate
    return default


def choices(cls: type, role: type) -> list[type]:
    """What may be nested in a block: a wrapper wraps no other here, and every signal is measured."""
    found = playing(role)
    return [one for one in found if one.__name__ not in NOTHING and not (wraps(one) and cls in found)]


def number(default: Any, field: Field, spread: Range) -> SearchStrategy[Any]:
    if isinstance(default, bool):
        return st.booleans()
    if default == field.auto:
        return positive(1e6, spread.decades)  # a start pressure
    low = field.above if field.above is not None else field.at_least
    high = field.below if field.below is not None else field.at_most
    if isinstance(default, int):
        return st.integers(int(low or 0), min(int(high or 50), 50))
    if low is not None and high is not None:
        inset = spread.margin * (high - low)
        return st.floats(low + inset, high - inset).filter(lambda x: within(x, field))
    near = negative if high == 0.0 else around if low is None else positive
    some = near(default or 1.0, spread.decades).filter(lambda x: within(x, field))
    return st.one_of(some, st.just(0.0)) if within(0.0, field) else some


def positive(scale: float, decades: float) -> SearchStrategy[float]:
    """A scale, some powers of ten up and down."""
    return st.floats(-decades, decades).map(lambda power: abs(scale) * 10.0**power)


def negative(scale: float, decades: float) -> SearchStrategy[float]:
    """The same below zero."""
    return positive(scale, decades).map(lambda x: -x)


def around(scale: float, decades: float) -> SearchStrategy[float]:
    """Both signs of a scale, some powers of ten up and down, and 0."""
    size = positive(scale, decades)
    return st.one_of(size, negative(scale, decades), st.just(0.0))


@st.composite
def series(draw: Any) -> TimeSeries:
    steps = draw(st.lists(st.floats(1e-4, 10.0), min_size=2, max_size=8))
    values = draw(st.lists(st.floats(-1e3, 1e3), min_size=len(steps), max_size=len(steps)))
    return TimeSeries.from_samples(np.cumsum(steps), values)


SCALES = {
    "a": 0.5,
    "command": 1.0,
    "D": 100.0,
    "drop": 4e6,
    "dt": 1e-4,
    "eps": 10.0,
    "force": 100.0,
    "k": 1000.0,
    "load_force": 100.0,
    "drawn": 1e-5,
    "load_pressure": 1e6,
    "mass": 10.0,
    "net": 100.0,
    "position": 0.03,
    "pressure": 1e6,
    "stroke": 0.08,
    "pressure_a": 1e6,
    "pressure_b": 1e6,
    "model_rate": 10.0,
    "opening": 1e-4,
    "supply_drop": 4e6,
    "t": 1.0,
    "u": 1.0,
    "value": 1.0,
    "velocity": 0.03,
}
NEVER_NEGATIVE = {"D", "dt", "eps", "k", "mass", "stroke", "t"}
MADE: dict[str, Callable[[Range], SearchStrategy[Block]]] = {
    "draws": lambda _: st.builds(Draws, whole_below(2**53), whole_below(2**16), whole_below(2**53)),
    "held": lambda _: st.builds(HeldTwice, around(1.0, 1.0), around(1.0, 1.0), positive(1.0, 1.0)),
    "model": lambda spread: block_of(DesignModel, spread),
    "edges": lambda spread: block_of(Orifice, spread),
}
RECORDS = {
    "y": Measurement,
    "r": Demand,
    "machine": MachineOutputs,
    "line": Pressures,
    "flows": PortFlows,
}


@cache
def argument(role: type, name: str, ordinary: bool) -> SearchStrategy[Any]:
    """Values of an argument of a role's methods: ordinary ones, or any that a 64-bit float can be.

    Raises:
        LookupError: the contract does not know the argument.
    """
    spread = ORDINARY if ordinary else WIDE
    if name in MADE:
        return MADE[name](spread)
    if name in RECORDS:
        return state(RECORDS[name](*(1.0 for _ in RECORDS[name]._fields)), ordinary)
    if role in (Reaching, Realisation) and name == "s":
        return signal(1e-3, ordinary)
    if role in (Reaching, Realisation) and name == "a":
        return st.floats(0.2, 0.8) if ordinary else st.floats(0.01, 0.99)
    if name not in SCALES:
        raise LookupError(f"{role.__name__} has an argument {name!r} that the contract does not know")
    if name in NEVER_NEGATIVE:
        return positive(SCALES[name], spread.decades)
    return signal(SCALES[name], ordinary)


def whole_below(limit: int) -> SearchStrategy[float]:
    return st.integers(0, limit - 1).map(float)


def signal(scale: float, ordinary: bool) -> SearchStrategy[float]:
    near = around(scale, 1.0)
    return near if ordinary else st.one_of(near, st.floats())


def state(example: Block, ordinary: bool) -> SearchStrategy[Block]:
    """States of the type of an example."""
    paths = [path for path, _ in leaves(example)]
    values = st.fixed_dictionaries({path: signal(0.1, ordinary) for path in paths})
    return values.map(lambda changes: replace(example, changes))
