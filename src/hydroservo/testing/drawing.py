"""Random parameters, states and inputs of blocks, by hypothesis."""

from collections.abc import Callable
from functools import cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from hydroservo.control.monitors.group import Usual
from hydroservo.core import signals
from hydroservo.core.block import Block, is_block, leaves, replace, values
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.roles import Monitor, Reaching, Realisation, Start
from hydroservo.core.states import filled
from hydroservo.core.validation import consistent, in_range, within
from hydroservo.machine.drives import ValveOnSupply, ValveOnSupplyState
from hydroservo.machine.drives.ports import Ports
from hydroservo.machine.mechanics import OneLinkArm
from hydroservo.machine.plants import DesignModel
from hydroservo.machine.supplies import ReliefValve
from hydroservo.machine.valves import Orifice
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario.role_checks import role_methods
from hydroservo.testing.examples import example
from hydroservo.testing.loops import watched_loop


class ParameterSpread(NamedTuple):
    """How far from a block's defaults its parameters may be."""

    decades: float  # number of powers of ten to either side
    margin: float  # share of a range bounded at both sides that is left out at each end


MANY = 50  # numbers of a nested block or of a state

ORDINARY = ParameterSpread(1.0, 0.2)
WIDE = ParameterSpread(4.0, 0.0)


def random_blocks(example: Block, spread: ParameterSpread) -> SearchStrategy[Block]:
    """Blocks of an example's class with random parameters around its own, in their ranges.

    Where those do not go together, as the block's ``check`` says, it is the example itself.
    """
    if isinstance(example, Curve):
        return curves()
    cls: Any = type(example)
    fields = declared_fields(cls)
    parts = {
        name: (random_table(value) if len(values(value)) > MANY else random_blocks(value, spread))
        if is_block(value)
        else random_number(value, fields.get(name, Field("", name)), spread)
        for name, value in zip(example._fields, example, strict=True)
    }
    return st.builds(cls, **parts).map(in_range).map(lambda one: one if is_consistent(one) else example)


def random_table(example: Block) -> SearchStrategy[Block]:
    """A block of so many numbers that they are one draw's, of the size of 1."""
    return generators().map(
        lambda some: filled(example, iter(some.normal(size=len(values(example))).tolist()))
    )


def generators() -> SearchStrategy[np.random.Generator]:
    """Generators of random numbers, each from one draw: hypothesis cannot draw hundreds of numbers."""
    return st.integers(0, 2**32 - 1).map(np.random.default_rng)


def is_consistent(block: Block) -> bool:
    """Whether the numbers of a block go together."""
    try:
        consistent(block)
    except ParameterError:
        return False
    return True


def random_number(default: Any, field: Field, spread: ParameterSpread) -> SearchStrategy[Any]:
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
def curves(draw: Any) -> Curve:
    steps = draw(st.lists(st.floats(1e-4, 10.0), min_size=2, max_size=8))
    values = draw(st.lists(st.floats(-1e3, 1e3), min_size=len(steps), max_size=len(steps)))
    return Curve.from_samples(np.cumsum(steps), values)


SCALES = {
    "D": 100.0,
    "a": 0.5,
    "acceleration": 10.0,
    "command": 1.0,
    "drawn": 1e-5,
    "drive": 1e-4,
    "drop": 4e6,
    "dt": 1e-4,
    "eps": 10.0,
    "force": 100.0,
    "k": 1000.0,
    "hydraulic_force": 100.0,
    "load_pressure": 1e6,
    "mass": 10.0,
    "model_rate": 10.0,
    "net": 100.0,
    "opening": 1e-4,
    "pilot": 1e6,
    "position": 0.03,
    "pressure": 1e6,
    "pressure_a": 1e6,
    "pressure_b": 1e6,
    "rate": 100.0,
    "stroke": 0.08,
    "supply_drop": 4e6,
    "t": 1.0,
    "tolerance": 1e-6,
    "u": 1.0,
    "value": 1.0,
    "velocity": 0.03,
}
NEVER_NEGATIVE = {"D", "dt", "eps", "k", "mass", "rate", "stroke", "t", "tolerance"}
RECORDS: dict[str, Any] = {
    "y": signals.Measurement,
    "r": signals.Demand,
    "error": signals.VelocityError,
    "machine": signals.MachineOutputs,
    "seen": signals.MachineOutputs,
    "line": signals.Pressures,
    "flows": signals.PortFlows,
}


class Swinging(NamedTuple):
    """The state of a system for integrators."""

    position: Annotated[float, Field("m", "position")]
    velocity: Annotated[float, Field("m/s", "velocity")]


class Oscillator(NamedTuple):
    """A system for integrators: x'' = 400 (u - x) - 4 x'."""

    def deriv(self, t: float, x: Swinging, u: float) -> Swinging:
        return Swinging(x.velocity, 400.0 * (u - x.position) - 4.0 * x.velocity)

    def next_jump(self, t: float, u: float) -> float:
        return np.inf


def feeds(spread: ParameterSpread) -> SearchStrategy[signals.Feed]:
    """What drives find at a valve and a supply."""
    ordinary = spread is ORDINARY
    line = st.builds(signals.Pressures, random_signal(4e6, ordinary), random_signal(1e5, ordinary))
    command, opening = (random_signal(SCALES[name], ordinary) for name in ("command", "opening"))
    return st.builds(signals.Feed, command, random_blocks(example(Orifice), spread), opening, line)


MADE: dict[str, Callable[[ParameterSpread], SearchStrategy[Any]]] = {
    "draws": lambda _: st.builds(signals.Draws, whole_below(2**53), whole_below(2**16), whole_below(2**53)),
    "model": lambda spread: random_blocks(example(DesignModel), spread),
    "mechanism": lambda spread: random_blocks(example(OneLinkArm), spread),
    "edges": lambda spread: random_blocks(example(Orifice), spread),
    "feed": feeds,
    "ports": lambda spread: st.builds(
        Ports, st.just(ValveOnSupply()), st.just(ValveOnSupplyState()), feeds(spread)
    ),
    "relief": lambda spread: random_blocks(example(ReliefValve), spread),
    "substeps": lambda _: st.integers(1, 5),
    "system": lambda _: st.just(Oscillator()),
    "x": lambda _: random_state(Swinging(0.0, 0.0), ordinary=True),
}


@st.composite
def arguments(draw: Any, block: Block, role: type, name: str, ordinary: bool) -> list[Any]:
    """Arguments of a block's method: ordinary ones, or any that a 64-bit float can be."""
    own = ("m" if role is Monitor else "s") if "init" in role_methods(role) else None
    rows = []
    for wanted in role_methods(role)[name][1:]:
        if wanted == own:
            rows.append(draw(random_state(block.init(), ordinary)))
        elif role is Start:
            rows.append(draw(loop_states(ordinary)))
        elif role is Monitor and wanted in RUNNING:
            rows.append(draw(RUNNING[wanted](ordinary)))
        elif wanted == "at":
            rows.append(block.at(draw(argument_values(role, "velocity", ordinary))))
        elif wanted == "held":
            rows.append(
                block.held(
                    draw(random_state(block.init(), ordinary)), draw(argument_values(role, "u", ordinary))
                )
            )
        else:
            rows.append(draw(argument_values(role, wanted, ordinary)))
    return rows


@cache
def argument_values(role: type, name: str, ordinary: bool) -> SearchStrategy[Any]:
    """Values of an argument of a role's methods."""
    spread = ORDINARY if ordinary else WIDE
    if name in MADE:
        return MADE[name](spread)
    if name in RECORDS:
        return random_state(RECORDS[name](*(1.0 for _ in RECORDS[name]._fields)), ordinary)
    if role in (Reaching, Realisation) and name == "s":
        return random_signal(1e-3, ordinary)
    if role in (Reaching, Realisation) and name == "a":
        return st.floats(0.2, 0.8) if ordinary else st.floats(0.01, 0.99)
    if name not in SCALES:
        raise LookupError(f"{role.__name__} has an argument {name!r} that the contract does not know")
    if name in NEVER_NEGATIVE:
        return positive(SCALES[name], spread.decades)
    return random_signal(SCALES[name], ordinary)


@cache
def prepared_watched_loop() -> Block:
    """The loop that monitors are shown, as it is before a run, without the monitors, as kernels have it."""
    return runnable_loop(watched_loop())._replace(metrics=Usual())


@cache
def loop_states(ordinary: bool) -> SearchStrategy[Block]:
    """States of that loop at an instant, each number of the size that its name tells."""
    example = prepared_watched_loop().init()
    paths = [path for path, _ in leaves(example)]
    sizes = {path: random_signal(SCALES.get(path.rpartition(".")[2], 0.1), ordinary) for path in paths}
    return st.fixed_dictionaries(sizes).map(lambda changes: replace(example, changes))


RUNNING: dict[str, Callable[[bool], SearchStrategy[Any]]] = {
    "loop": lambda _: st.just(prepared_watched_loop()),
    "s": loop_states,
}


def whole_below(limit: int) -> SearchStrategy[float]:
    return st.integers(0, limit - 1).map(float)


@cache
def random_signal(scale: float, ordinary: bool) -> SearchStrategy[float]:
    near = around(scale, 1.0)
    return near if ordinary else st.one_of(near, st.floats())


def random_state(example: Block, ordinary: bool) -> SearchStrategy[Block]:
    """States of the type of an example."""
    changed = changes_at(tuple(path for path, _ in leaves(example)), ordinary)
    return changed.map(lambda changes: replace(example, changes))


@cache  # what strategies look like is worth more time than what they draw
def changes_at(paths: tuple[str, ...], ordinary: bool) -> SearchStrategy[dict[str, float]]:
    number = random_signal(0.1, ordinary)
    if len(paths) <= MANY:
        return st.fixed_dictionaries(dict.fromkeys(paths, number))
    few = st.lists(number, min_size=1, max_size=MANY)
    return st.builds(
        lambda some, few: dict(zip(paths, some.choice(few, len(paths)).tolist(), strict=True)),
        generators(),
        few,
    )
