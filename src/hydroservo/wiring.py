"""What a loop leaves open and its machine answers: a law's model of it, the areas that sensors know.

The one place for Python, scenarios and the command line.
"""

from hydroservo.block import Block, field_at, is_block
from hydroservo.errors import ParameterError
from hydroservo.hooks import at_rest
from hydroservo.loop import Loop
from hydroservo.plants.design_model import DesignModel, ThisMachine
from hydroservo.validation import consistent

__all__ = ["believed", "wired", "with_model"]


def wired(loop: Loop) -> Loop:
    """The loop with what it leaves open filled from its machine as it is.

    A law that holds :class:`~hydroservo.plants.ThisMachine` for its model believes in what :func:`believed`
    makes of the machine; sensors whose areas are automatic know those of the plant. What is given stays.

    Raises:
        ParameterError: the machine does not answer, or cannot rest at its start.
    """
    sensors = with_plant_areas(loop.sensors, loop.plant, "sensors")
    controller = loop.controller
    if is_open(controller):
        controller = with_model(controller, believed(loop))
    return loop._replace(sensors=sensors, controller=controller)


def believed(loop: Block) -> DesignModel:
    """What a law takes a machine for that is told nothing else: the machine simplified, at rest at its start.

    Args:
        loop: the loop, or anything with its plant, valve, supply and load.

    Raises:
        ParameterError: a block of the machine has no simplified form, or the machine cannot rest at its
            start.
    """
    check_simple(loop)
    plant = at_rest(loop.plant, loop.supply, loop.load).simplified()
    found = DesignModel(plant, loop.valve.orifice.simplified(), loop.supply.simplified(), loop.valve.gain)
    consistent(found)
    return found


def check_simple(loop: Block) -> None:
    """Refuse a machine that has no design model, and say which block is in the way.

    Raises:
        ParameterError: the valve has no gain, or a block has no method simplified.
    """
    why = "for the controller's model of it; else give the controller a model"
    orifice, gain = (getattr(loop.valve, name, None) for name in ("orifice", "gain"))
    if not (hasattr(orifice, "simplified") and isinstance(gain, float)):
        needed = (
            f"must have a field gain (a float) and a field orifice, metering edges with simplified(), {why}"
        )
        raise ParameterError("valve", type(loop.valve).__name__, needed)
    for part in ("plant", "supply"):
        block = getattr(loop, part)
        if not hasattr(block, "simplified"):
            raise ParameterError(part, type(block).__name__, f"must have a method simplified(), {why}")


def is_open(block: Block) -> bool:
    """Whether a controller, or a block in it, holds :class:`ThisMachine` for a model."""
    return isinstance(block, ThisMachine) or any(is_open(part) for part in block if is_block(part))


def with_model(block: Block, model: DesignModel) -> Block:
    """A controller, and the blocks in it, with a model in place of :class:`ThisMachine`."""
    if isinstance(block, ThisMachine):
        return model
    parts = {name: with_model(part, model) for name, part in block._asdict().items() if is_block(part)}
    return block._replace(**parts)


def with_plant_areas(sensors: Block, plant: Block, path: str) -> Block:
    """Sensors that know the areas of the plant where they are automatic."""
    if hasattr(sensors, "sensors"):  # around others
        return sensors._replace(sensors=with_plant_areas(sensors.sensors, plant, f"{path}.sensors"))
    found = {}
    for name in ("area_a", "area_b"):
        if name in sensors._fields and getattr(sensors, name) == field_at(sensors, name).auto:
            found[name] = getattr(plant, name, getattr(plant, "piston_area", None))
            if found[name] is None:
                problem = f"must be given: the plant {type(plant).__name__} has no {name}, nor a piston_area"
                raise ParameterError(f"{path}.{name}", "auto", problem)
    return sensors._replace(**found)
