"""What a loop leaves open and itself answers: a law's model, the areas that sensors know, a law's signal.

The one place for Python, scenarios and the command line. :func:`wired` fills in models and areas;
:func:`with_signal` the signal, which :func:`~hydroservo.runs.run.runnable_loop` asks for before a run.
"""

from hydroservo.control.controlled.command import Command
from hydroservo.control.controlled.this_signal import ThisSignal
from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, field_at, inner_controls, is_block
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import at_rest, has_chambers, is_valveless, takes_load_pressure
from hydroservo.core.validation import consistent
from hydroservo.machine.plants.design_model import DesignModel, ThisMachine
from hydroservo.machine.valves.no_valve import NoValve


def wired(loop: Loop) -> Loop:
    """The loop with what it leaves open filled from its machine as it is.

    A law that holds :class:`~hydroservo.machine.plants.ThisMachine` for its model believes in what
    :func:`believed` makes of the machine; sensors whose areas are automatic know those of the plant. What is
    given stays. Laws keep :class:`~hydroservo.control.controlled.this_signal.ThisSignal` until a run begins,
    so that ``replace(loop, {"controls": Position()})`` of a wired loop is a loop of the other signal.

    Raises:
        ParameterError: the machine does not answer, or cannot rest at its start; the law cannot control what
            the loop does, or run at its sample period; or the drive needs a valve or chambers that are not
            there, or has no use for one.
    """
    check_valve(loop)
    check_chambers(loop)
    sensors = with_plant_areas(loop.sensors, loop.plant, "sensors")
    controller = loop.controller
    check_signals(controller, loop.controls, "controller")
    if is_open(controller):
        controller = with_model(controller, believed(loop))
    return loop._replace(sensors=sensors, controller=controller)


def check_valve(loop: Loop) -> None:
    """Refuse a valve that the drive has no use for, and a drive without the valve that it needs."""
    drive, valve = type(loop.drive).__name__, type(loop.valve).__name__
    if is_valveless(loop.drive) and not isinstance(loop.valve, NoValve):
        raise ParameterError(
            "valve", valve, f"must be NoValve: the drive {drive} stands in the valve's place"
        )
    if isinstance(loop.valve, NoValve) and not is_valveless(loop.drive):
        raise ParameterError("valve", valve, f"is none, and the drive {drive} needs one")


def check_chambers(loop: Loop) -> None:
    """Refuse a drive that works from the pressures of two chambers on a plant that has none."""
    if not (has_chambers(loop.plant) or takes_load_pressure(loop.drive)):
        plant = type(loop.plant).__name__
        problem = f"works from the pressures of two chambers, and the plant {plant} has none; use a Cylinder"
        raise ParameterError("drive", type(loop.drive).__name__, problem)


def believed(loop: Block) -> DesignModel:
    """What a law takes a machine for that is told nothing else: the machine simplified, at rest at its start.

    Args:
        loop: the loop, or anything with its plant, valve, supply, drive and load.

    Raises:
        ParameterError: a block of the machine has no simplified form, or the machine cannot rest at its
            start.
    """
    check_simple(loop)
    plant = at_rest(loop).simplified()
    gain: float = loop.valve.gain
    found = DesignModel(plant, loop.valve.orifice.simplified(), loop.supply.simplified(), gain)
    consistent(found)
    return found


def check_simple(loop: Block) -> None:
    """Refuse a machine that has no design model, and say which block is in the way."""
    why = "for the controller's model of it; else give the controller a model"
    if is_valveless(loop.drive):
        problem = (
            "has no design model: no valve meters the flow; give the controller a model, or use another law"
        )
        raise ParameterError("drive", type(loop.drive).__name__, problem)
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


def with_signal(block: Block, controls: Block) -> Block:
    """A controller, and the blocks in it, with what they control in place of :class:`ThisSignal`.

    That is the signal of the loop, or what the law around it controls, or has as its ``inner_controls``.
    """
    if isinstance(block, ThisSignal):
        return controls
    own = getattr(block, "controls", controls)
    controls = controls if isinstance(own, ThisSignal) else own
    parts = {
        name: with_signal(part, inner_signal(block, name, controls))
        for name, part in block._asdict().items()
        if is_block(part)
    }
    return block._replace(**parts)


def inner_signal(law: Block, name: str, controls: Block) -> Block:
    """What a block in a law is to control.

    Args:
        law: the outer law.
        name: of the inner block, as a field of it.
        controls: what the outer law is to control.
    """
    inner = inner_controls(law, name)
    return controls if inner is None else with_signal(inner, controls)


def check_signals(law: Block, controls: Block, path: str) -> None:
    """Refuse a law that cannot control what its loop does."""
    name, own = controls.declared().meaning, getattr(law, "controls", None)
    fixed = () if own is None or isinstance(own, ThisSignal) else (type(own),)
    able = getattr(law, "signals", fixed) or (type(controls),)
    if type(controls) not in able:
        others = " or ".join(one().declared().meaning for one in able)
        problem = f"controls the {others}, and here the {name} is controlled"
        raise ParameterError(path, type(law).__name__, problem)
    if own is not None and isinstance(controls, Command):
        problem = "closes a loop, and an open one has none: its law is OpenLoop"
        raise ParameterError(path, type(law).__name__, problem)
    for name in ("controller", "limiting"):
        if name in law._fields:
            inner = inner_signal(law, name, own if fixed else controls)
            check_signals(getattr(law, name), inner, f"{path}.{name}")


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
