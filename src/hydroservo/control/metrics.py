"""What a run is judged by: its monitors, the metrics that they give, and whether it diverged."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, NamedTuple

from hydroservo.control import monitors
from hydroservo.control.controlled import Command, Velocity
from hydroservo.control.loop import Loop
from hydroservo.control.monitors.group import Usual, by_class
from hydroservo.core.block import Block, estimates_in, is_block, model_in
from hydroservo.core.errors import LoopError
from hydroservo.core.field import Field, declared_fields

VELOCITY = Velocity()


class Divergence(NamedTuple):
    """Whether a run was lost; part of every result, whatever its monitors."""

    diverged: Annotated[
        bool, Field("", "a number of the state stopped being finite, or left physical reach")
    ] = False
    diverged_at: Annotated[
        float, Field("s", "sample at which it did; nan if none did", least_is_worst=True)
    ] = math.nan


def usual(loop: Loop) -> dict[str, Block]:
    """The monitors that a loop usually has, by name.

    Tracking error, step response, sustained oscillation, command and the piston's travel; pressures where the
    plant has chambers, and the lumped disturbances where the law has a model and an observer that estimates
    them. Of an open loop no error: its demand is the command itself.
    """
    open_loop = isinstance(loop.controls, Command)
    found: list[Block] = (
        [] if open_loop else [monitors.TrackingError(), monitors.StepResponse(), monitors.Oscillation()]
    )
    found.append(monitors.CommandEffort())
    if model_in(loop.controller) is not None and estimates_in(loop.controller.init()) is not None:
        found.append(monitors.Disturbance())
    found.append(monitors.PistonTravel())
    if {"pressure_a", "pressure_b"} <= set(loop.plant.init()._fields):
        found.append(monitors.ChamberPressures())
    return by_class(found)


def default_metric(names: Iterable[str], usual: str) -> str:
    """The metric that is shown where none is asked for: of a loop without an error, how far the piston goes.

    Args:
        names: of the metrics that there are, at least one.
        usual: the name of the one that nearly all loops have.
    """
    known = list(names)
    return next((name for name in (usual, "position_max") if name in known), known[0])


def monitors_of(loop: Loop) -> dict[str, Block]:
    """The monitors of a loop by name: those that it asks for, with the usual ones where it asks for these."""
    if isinstance(loop.metrics, Usual):
        return usual(loop)
    found: dict[str, Block] = {}
    for name, one in loop.metrics._asdict().items():
        found |= usual(loop) if isinstance(one, Usual) else {name: one}
    return found


def declared_metrics(watching: Mapping[str, Block], controls: Block = VELOCITY) -> dict[str, Field]:
    """The metrics that monitors give, and whether the run diverged, by name.

    One that another monitor gives already has the name of its monitor before its own.

    Args:
        watching: the monitors by name.
        controls: the signal that their loop controls, on which units depend.
    """
    signal = controls.declared()
    found = dict(declared_fields(Divergence))
    for name, monitor in watching.items():
        values = values_at_start(name, monitor)
        fields = fields_of(values)
        for own in values._fields:
            found[f"{name}_{own}" if own in found else own] = fields.get(own, Field("", own)).of(signal)
    return dict(sorted(found.items(), key=lambda item: item[0] in Divergence._fields))


def values_at_start(name: str, monitor: Block) -> Block:
    """What a monitor gives before it has heard anything."""
    try:
        found = monitor.values(monitor.init())
    except Exception as error:  # whatever a user's block stumbles over
        raise LoopError(
            f"the metric {name} ({type(monitor).__name__}) gives no values at the start: {error}"
        ) from None
    if not is_block(found):
        raise LoopError(f"the metric {name}: values must be a NamedTuple of floats and flags")
    return found


def flags_of(watching: Mapping[str, Block]) -> set[str]:
    """The metrics that are true or false."""
    empty = values_of(watching, [one.init() for one in watching.values()], Divergence())
    names = declared_metrics(watching)
    return {name for name, value in zip(names, empty, strict=True) if isinstance(value, bool)}


def values_of(
    watching: Mapping[str, Block], states: Iterable[Block], divergence: Divergence
) -> list[float | bool]:
    """The values of a run's metrics, in the order in which they are declared.

    Args:
        watching: its monitors by name.
        states: what each of them gathered.
        divergence: whether it was lost.
    """
    pairs = zip(watching.values(), states, strict=True)
    return [*(value for monitor, state in pairs for value in monitor.values(state)), *divergence]


def signals_of(loop: Loop) -> dict[str, Field]:
    """What of the monitors' states can be recorded: the numbers that are declared, such as disturbance.d1."""
    signal = loop.controls.declared()
    return {
        f"{name}.{own}": field.of(signal)
        for name, monitor in monitors_of(loop).items()
        for own, field in fields_of(monitor.init()).items()
    }


def judged_by(loops: Sequence[Loop]) -> dict[str, Field]:
    """The metrics that all of some loops have and of which less is better: by which gains are tuned."""
    every = [declared_metrics(monitors_of(loop), loop.controls) for loop in loops]
    return {
        name: field
        for name, field in every[0].items()
        if field.smaller_is_better and all(name in fields for fields in every)
    }


def fields_of(block: Block) -> Mapping[str, Field]:
    """The declarations of a block's numbers by name."""
    return declared_fields(block.__class__)


def all_fields() -> dict[str, Field]:
    """The metrics of hydroservo's own monitors by name, for a loop that controls the velocity."""
    own = by_class([getattr(monitors, name)() for name in monitors.__all__])
    return declared_metrics(own)


METRIC_FIELDS = all_fields()
