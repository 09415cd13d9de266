"""A loop in which a block of any role works."""

from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple, get_type_hints

from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import TSMC
from hydroservo.control.loop import Loop, Simulation
from hydroservo.control.monitors import TrackingError
from hydroservo.core.block import Block, is_block, replace, value_at
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.group import group
from hydroservo.core.hooks import at_rest, has_chambers, is_valveless, takes_load_pressure
from hydroservo.core.roles import Controller, Hold, Monitor
from hydroservo.export.c.project import proof_of
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part
from hydroservo.export.vectors import make_vectors
from hydroservo.machine.drives import PumpDrive
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.sensors.missing import missing_signals
from hydroservo.machine.valves import NoValve
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario.registry import shipped_classes
from hydroservo.scenario.role_checks import ROLES, a_role, declared_roles
from hydroservo.testing.case import Case
from hydroservo.testing.examples import example

PERIOD = 1e-4  # s
PERIODS = 1000
START = 2e6  # Pa


class BlockPlace(NamedTuple):
    """A field of a block in a loop."""

    loop: Loop
    path: str
    kind: Any  # the type that the field is declared with


def loop_with(block: Block, role: type) -> Loop | None:
    """The first loop, by how deep it is nested, that takes a block in a role; None where no loop does.

    Blocks around it are those that hydroservo has, with their defaults, or examples where they have none.
    """
    for place in block_places():
        if place.kind in (role, type(block)):
            late = getattr(block, "delay", 0.0) if role is Hold else 0.0
            period = 2.0 * late or PERIOD  # one of the two steps in it ends where the command comes
            simulation = Simulation(PERIODS * period, period, substeps=2, record_period=period)
            found: Loop = replace(place.loop, {"simulation": simulation, place.path: block})
            return start_in_motion(with_its_machine(found._replace(controls=signal_for(found.controller))))
    return None


def start_in_motion(loop: Loop) -> Loop:
    """Let a loop start in motion where its cylinder cannot hold the weight of the block that is asked."""
    try:
        at_rest(loop)
    except ParameterError:
        if isinstance(loop.plant, Cylinder):
            plant = loop.plant._replace(start_pressure_a=START, start_pressure_b=START)
            return loop._replace(plant=plant)
    return loop


def signal_for(law: Block) -> Block:
    """What a loop is to control with a law: the velocity, unless the law says that it cannot."""
    return (getattr(law, "signals", ()) or (Velocity,))[0]()


def with_its_machine(loop: Loop) -> Loop:
    """A loop whose plant, valve and drive go together: with chambers, and a valve or none, as that needs."""
    if not (has_chambers(loop.plant) or takes_load_pressure(loop.drive)):
        loop = loop._replace(plant=example(Cylinder))
    if is_valveless(loop.drive):
        return loop._replace(valve=NoValve())
    return loop._replace(drive=example(PumpDrive)) if isinstance(loop.valve, NoValve) else loop


def block_places() -> Iterator[BlockPlace]:
    """The fields that hold blocks, in a loop and in each block that it may hold, and a monitor's place."""
    yield BlockPlace(watched_loop(), "metrics.asked", Monitor)
    seen: set[type] = set()
    waiting = deque((example(Loop), path) for path in Loop._fields)
    while waiting:
        loop, path = waiting.popleft()
        here, kind = value_at(loop, path), kind_at(loop, path)
        if not is_block(here):
            continue
        yield BlockPlace(loop, path, kind)
        others = [cls for cls in shipped_classes() if kind in declared_roles(cls)] if kind in ROLES else []
        for cls in dict.fromkeys([type(here), *others]):
            if cls not in seen:
                seen.add(cls)
                block: Block = here if cls is type(here) else example(cls)
                inside = replace(loop, {path: block})
                waiting.extend((inside, f"{path}.{name}") for name in block._fields)


def watched_loop() -> Loop:
    """A loop with all that a monitor may read: chambers, and a law with a model and an observer."""
    return example(
        Loop, plant=example(Cylinder), controller=example(TSMC), metrics=group({"asked": TrackingError()})
    )


def kind_at(loop: Loop, path: str) -> Any:
    parent, _, name = path.rpartition(".")
    holder = value_at(loop, parent) if parent else loop
    return get_type_hints(type(holder))[name]


def check_translated(case: Case) -> str:
    """A loop with it is exported as C, which gives the bits of plain Python."""
    if case.role is Monitor:
        return "not tried: a metric is not part of what is exported"
    loop = loop_with(case.block, case.role)
    if loop is None:
        return f"not tried: no block of hydroservo takes {a_role(case.role)} of your own"
    if "velocity" in missing_signals(loop.sensors):
        return "not tried: the controller beside it needs the velocity"
    try:
        runnable_loop(loop)
    except ParameterError as error:  # the block's own numbers are asked about elsewhere
        return f"not tried: the machine of this check does not go with it: {error}"
    if case.role is Controller:
        exported_with(case, loop, Part.CONTROLLER)  # as export does, which refuses what a whole loop may have
    unit = exported_with(case, loop, Part.LOOP)
    try:
        unproved = proof_of(unit, make_vectors(loop, Part.LOOP, unit)).unproved
    except HydroservoError as error:
        raise case.error(str(error)) from error
    return f"bits not compared: {unproved}" if unproved else ""


def exported_with(case: Case, loop: Loop, part: Part) -> CModule:
    try:
        return exported_unit(loop, part, prefix="block", title=case.cls.__name__)
    except HydroservoError as error:
        raise case.error(str(error)) from error
