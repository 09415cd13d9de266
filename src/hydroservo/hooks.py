"""What a block may have besides the methods of its role, and who asks for it.

Methods among them are called in plain Python before a run, never compiled. A role's docstring names its own.
"""

from collections.abc import Callable
from typing import NamedTuple

from hydroservo.block import Block, is_block
from hydroservo.errors import ParameterError
from hydroservo.roles import (
    Accumulator,
    Controller,
    Hold,
    Integrator,
    Mechanism,
    MeteringEdges,
    Monitor,
    Plant,
    Sensors,
)

__all__ = ["HOOKS", "Hook", "at_rest", "designed"]


class Hook(NamedTuple):
    """A method or field that is used where a block has it.

    Attributes:
        name: of the method or field.
        role: of the blocks that may have it; None for blocks of any role.
        arguments: of a method, after self; None for a field.
        meaning: what it does, or what is done with it.
    """

    name: str
    role: type | None
    arguments: tuple[str, ...] | None
    meaning: str


HOOKS = (
    Hook("check", None, (), "raises a ParameterError where the block's numbers do not go together"),
    Hook(
        "designed",
        Controller,
        ("model", "period"),
        "the controller, or a block in it, with its gains computed",
    ),
    Hook("model", Controller, None, "what the controller, or a block in it, believes of the machine"),
    Hook("controller", Controller, None, "the controller that this one wraps"),
    Hook("saturation", Controller, None, "the controller's own limiter, which AntiWindup asks to be wide"),
    Hook("sensors", Sensors, None, "the sensors that these wrap"),
    Hook("missing", Sensors, (), "the fields of a measurement that the sensors do not measure"),
    Hook(
        "area_a", Sensors, None, "the piston's area [m^2] towards chamber a as known; automatic: the plant's"
    ),
    Hook(
        "area_b", Sensors, None, "the piston's area [m^2] towards chamber b as known; automatic: the plant's"
    ),
    Hook("at_rest", Plant, ("line", "force"), "the plant with what is left open of its start found"),
    Hook("area_a", Plant, None, "the piston's area [m^2] towards chamber a, for sensors of pressures"),
    Hook("area_b", Plant, None, "the piston's area [m^2] towards chamber b, for sensors of pressures"),
    Hook("piston_area", Plant, None, "both areas [m^2] of a plant that has but one"),
    Hook("positions", Mechanism, (), "the least and the largest position that the mechanism can take [m]"),
    Hook("lap", MeteringEdges, None, "the overlap of the edges [m], which the spool must pass"),
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
    return block.designed(known(), period) if hasattr(block, "designed") else block


def at_rest(plant: Block, supply: Block, load: Block) -> Block:
    """A plant with what is left open of its start found, if it has ``at_rest(line, force)``.

    Args:
        plant: the plant.
        supply: what feeds it; its pressures at the start count.
        load: what acts on it; its force at t = 0 counts.

    Raises:
        ParameterError: nothing keeps the plant at rest.
    """
    if not hasattr(plant, "at_rest"):
        return plant
    try:
        return plant.at_rest(supply.pressures(supply.init()), load.force(0.0))
    except ParameterError as error:
        raise ParameterError(f"plant.{error.path}", error.value, error.allowed) from None
    except ArithmeticError as error:
        raise ParameterError("plant", type(plant).__name__, f"has no start at rest: {error}") from None
