"""What a block may have besides the methods of its role, and who asks for it.

Methods among them are called in plain Python before a run, and compiled only where that is said. A role's
docstring names its own.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from hydroservo.core.block import Block, is_block
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import (
    Accumulator,
    Carried,
    CheckFlow,
    ControlledSignal,
    Controller,
    Drive,
    Hold,
    Integrator,
    Limiter,
    Mechanism,
    MeteringEdges,
    Monitor,
    Observer,
    Plant,
    Reaching,
    Realisation,
    Reference,
    Sensors,
    Start,
    Valve,
)
from hydroservo.core.signals import Pressures
from hydroservo.core.states import overlaid


class Hook(NamedTuple):
    """A method or field that is used where a block has it."""

    name: str  # of the method or field
    role: type | None  # of the blocks that may have it; None for blocks of any role
    arguments: tuple[str, ...] | None  # of a method, after self; None for a field
    meaning: str  # what it does, or what is done with it


HOOKS = (
    Hook("check", None, (), "raises a ParameterError where the block's numbers do not go together"),
    Hook("caution", None, (), "a line on numbers that are allowed and doubtful, which runs say; or empty"),
    Hook("smoothed", None, (), "the block without its steps of resolution, as small motions are judged with"),
    Hook(
        "designed",
        Controller,
        ("model", "period"),
        "the controller, or a block in it, with its gains computed, once for the same numbers",
    ),
    Hook("assumptions", None, ("facts",), "what the block supposes of its loop, each an Assumption"),
    Hook(
        "within",
        None,
        ("facts",),
        "the facts as blocks in this one meet them, which it tells of what they would not know",
    ),
    Hook(
        "supposes",
        Reaching,
        ("eps", "a", "size", "unit", "dt"),
        "what a power eps |s|^a supposes on a surface of that size",
    ),
    Hook(
        "supposes",
        Realisation,
        ("D", "noise", "dt", "unit"),
        "what a switching gain D supposes on a surface that is measured with some noise",
    ),
    Hook("model", Controller, None, "what the controller, or a block in it, believes of the machine"),
    Hook(
        "without_estimates",
        Observer,
        None,
        "there on a state whose d1 and d2 are no estimates, by ``@without_estimates``",
    ),
    Hook("controller", Controller, None, "the controller that this one wraps"),
    Hook("limiting", Controller, None, "a law inside that controls a signal of its own"),
    Hook("controls", Controller, None, "the signal that the law controls; ThisSignal: that of its loop"),
    Hook("signals", Controller, None, "the signals that the law can control, said by ``@controlling``"),
    Hook("inner_controls", Controller, None, "what the law in ``controller`` controls if another"),
    Hook("saturation", Controller, None, "the controller's own limiter, which AntiWindup asks to be wide"),
    Hook(
        "reach",
        ControlledSignal,
        ("plant", "line"),
        "the least and the largest value that a machine can hold",
    ),
    Hook("sensors", Sensors, None, "the sensors that these wrap"),
    Hook("missing", Sensors, (), "the fields of a measurement that the sensors do not measure"),
    Hook(
        "area_a", Sensors, None, "the piston's area [m^2] towards chamber a as known; automatic: the plant's"
    ),
    Hook(
        "area_b", Sensors, None, "the piston's area [m^2] towards chamber b as known; automatic: the plant's"
    ),
    Hook("at_rest", Plant, ("line", "force"), "the plant with what is left open of its start found"),
    Hook("valveless", Drive, None, "there where the drive stands in the valve's place, by @valveless"),
    Hook("drive", Drive, None, "the drive that this one lies before"),
    Hook(
        "at_rest",
        Drive,
        ("line", "pressure_a", "pressure_b"),
        "the drive with what is left open of its start found, at the pressures of its feed and the chambers",
    ),
    Hook(
        "load_flow",
        Drive,
        ("s", "feed", "load_pressure"),
        "the one flow [m^3/s] to a plant that is described by its load pressure; compiled",
    ),
    Hook("pilot_ratio", CheckFlow, None, "the ratio of areas by which a pilot opens it"),
    Hook("area_a", Plant, None, "the piston's area [m^2] towards chamber a, for sensors of pressures"),
    Hook("area_b", Plant, None, "the piston's area [m^2] towards chamber b, for sensors of pressures"),
    Hook("piston_area", Plant, None, "both areas [m^2] of a plant that has but one"),
    Hook(
        "check_within",
        Mechanism,
        ("start_position", "stroke"),
        "refuses a piston's start or stroke [m] that the mechanism does not go with",
    ),
    Hook("positions", Mechanism, (), "the least and the largest position that the mechanism can take [m]"),
    Hook("gain", Valve, None, "what a design model knows of the spool [m/V]"),
    Hook("time", Reference, None, "when the demand begins to change [s], which runs want within them"),
    Hook("max_opening", Valve, None, "how far the spool travels to either side [m]"),
    Hook("limit", Limiter, None, "the largest command [V]"),
    Hook("tip", Mechanism, ("position",), "how the tip, which can carry something, moves: a Tip; compiled"),
    Hook("check_on", Carried, ("mechanism",), "raises a ParameterError where that mechanism cannot carry it"),
    Hook("lap", MeteringEdges, None, "the overlap of the edges [m], which the spool must pass"),
    Hook("shape", MeteringEdges, None, "how the edges open as the spool moves, an EdgeShape; else straight"),
    Hook("precharge", Accumulator, None, "the pressure [Pa] up to which the accumulator takes in nothing"),
    Hook("delay", Hold, None, "the computing delay [s], with which steps of integrators are to end"),
    Hook(
        "substep",
        Integrator,
        ("system", "t", "x", "u", "h"),
        "one of the equal steps that make ``advance``; runs side by side, and monitors between them, need it",
    ),
    Hook(
        "begin",
        Integrator,
        ("t", "dt", "substeps"),
        "how far a sample period is integrated, at its start; monitors between chosen steps need it",
    ),
    Hook(
        "attempt",
        Integrator,
        ("system", "t", "x", "u", "dt", "p"),
        "the state after one more step that ``advance`` tries, and how far that is: p.gone seconds",
    ),
    Hook(
        "most_steps",
        Integrator,
        None,
        "steps of least length in a sample period; with twice as many a second run judges chosen steps",
    ),
    Hook(
        "found",
        Start,
        ("steady",),
        "numbers of the state in which the loop is to begin; steady(command) is its machine's steady state",
    ),
    Hook(
        "command", Start, None, "under which ``found`` asks for the steady state; sought for all runs at once"
    ),
    Hook("at_samples", Monitor, None, "there where its step comes at samples alone"),
)


def designed(block: Block, period: float, model: Callable[[], Block]) -> Block:
    """A controller with what is computed before a run, in each block that has ``designed(model, period)``.

    Args:
        block: the controller or a block in it.
        period: the sample period [s].
        model: gives the design model for a block that has none around it; a ``model`` around it goes before.

    Raises:
        ParameterError: a block's parameters allow no design.
    """
    own = getattr(block, "model", None)
    known = model if own is None else lambda: own
    nested = {
        name: designed(value, period, known) for name, value in block._asdict().items() if is_block(value)
    }
    block = block._replace(**nested)
    if not hasattr(block, "designed"):
        return block
    believed = known()
    try:
        hash((block, believed))
    except TypeError:  # an array among the numbers
        return block.designed(believed, period)
    return designed_once(block, believed, period, (value_kind(block), value_kind(believed)))


@lru_cache(maxsize=4096)  # many generations of a search, all of whose loops ask for the same
def designed_once(block: Block, model: Block, period: float, _kinds: Any) -> Block:
    """What one block computes before a run, for a model and a sample period [s].

    Args:
        block: with what is in it designed.
        model: the design model.
        period: the sample period [s].
        _kinds: of both, for to Python blocks of other classes with the same numbers are the same.
    """
    return block.designed(model, period)


def value_kind(value: Any) -> Any:
    """What two equal values may yet differ in: their classes, those of what is in them, and a zero's sign."""
    if is_block(value):
        return (type(value), *map(value_kind, value))
    return math.copysign(1.0, value) if type(value) is float else type(value)


def smoothed(block: Block) -> Any:
    """A block without steps of resolution and dither, in it or in a block in it that has ``smoothed()``."""
    parts = {name: smoothed(part) for name, part in block._asdict().items() if is_block(part)}
    block = block._replace(**parts)
    return block.smoothed() if hasattr(block, "smoothed") else block


def line_pressures(machine: Block) -> Pressures:
    """The pressures of the supply and the tank's line at the start, with those that a scenario gives."""
    supply, state = machine.supply, machine.supply.init()
    given = machine.start.given._asdict() if "start" in machine._fields else {}
    line: Pressures = supply.pressures(overlaid(state, given["supply"]) if "supply" in given else state)
    return line


def at_rest(machine: Block) -> Block:
    """The plant of a machine with what is left open of its start found, if it has ``at_rest(line, force)``.

    Raises:
        ParameterError: nothing keeps the plant at rest.
    """
    plant = machine.plant
    if not hasattr(plant, "at_rest"):
        return plant
    try:
        return plant.at_rest(line_pressures(machine), machine.load.force(0.0))
    except ParameterError as error:
        raise ParameterError(f"plant.{error.path}", error.value, error.allowed) from None
    except ArithmeticError as error:
        raise ParameterError("plant", type(plant).__name__, f"has no start at rest: {error}") from None


def at_ports(drive: Block, line: Pressures, pressure_a: float, pressure_b: float) -> Block:
    """A drive with what is left open of its start found, if it has ``at_rest(line, pressure_a, pressure_b)``.

    One that has not, and lies before another, passes the pressures on to that.
    """
    if hasattr(drive, "at_rest"):
        return drive.at_rest(line, pressure_a, pressure_b)
    inner = getattr(drive, "drive", None)
    return drive if inner is None else drive._replace(drive=at_ports(inner, line, pressure_a, pressure_b))


def resting(machine: Block) -> Any:
    """A machine, or a loop, with what is left open of the start of its plant and its drive found.

    Raises:
        ParameterError: nothing keeps the plant at rest.
    """
    plant = at_rest(machine)
    if not any(hasattr(drive, "at_rest") for drive in drives_in(machine.drive)):
        return machine._replace(plant=plant)
    line = line_pressures(machine)
    seen = plant.outputs(plant.init(), line, 0.0)
    drive = at_ports(machine.drive, line, seen.pressure_a, seen.pressure_b)
    return machine._replace(plant=plant, drive=drive)


def is_valveless(drive: Block) -> bool:
    """Whether a drive stands in the valve's place, itself or by the drive that it lies before."""
    return any(hasattr(type(one), "valveless") for one in drives_in(drive))


def takes_load_pressure(drive: Block) -> bool:
    """Whether a plant described by its load pressure can have a drive: all in it have ``load_flow``."""
    return all(hasattr(one, "load_flow") for one in drives_in(drive))


def has_chambers(plant: Block) -> bool:
    """Whether a plant's state holds the pressures of two chambers."""
    return {"pressure_a", "pressure_b"} <= set(plant.init()._fields)


def drives_in(drive: Block) -> list[Block]:
    """A drive, and those that it lies before."""
    inner = getattr(drive, "drive", None)
    return [drive] if inner is None else [drive, *drives_in(inner)]
