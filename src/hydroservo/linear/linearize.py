"""The linear models of a machine, a law and their loop."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import AUTO, Loop, LoopState
from hydroservo.core.block import Block, field_at, leaves, signal_of, state_field_at, values
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.hooks import smoothed
from hydroservo.core.signals import Demand, MachineOutputs, Measurement
from hydroservo.core.states import filled
from hydroservo.core.validation import checked_number
from hydroservo.cosimulation import refuse_fmus
from hydroservo.linear.linearization import InexactSlope, Linearization, Quantity
from hydroservo.linear.operating_point import DigitalState, OperatingPoint, machine_point, operating_point
from hydroservo.linear.slopes import Slopes
from hydroservo.linear.system import (
    COMMAND,
    FORCE,
    System,
    close_loop,
    law_slopes,
    machine_slopes,
    opened_system,
    part_slopes,
    reduced_system,
)
from hydroservo.runs.arguments import checked_loop
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import runnable_loop, simulate

COMMANDED = Quantity("command", "V")
LOADED = Quantity("load.force", "N")
CERTAIN = 1e-6  # of a derivative: what differences may be off without a kink
TOLD = {"command": "applied_command"}  # what a law is told of its own command is not what it asks for


class Names(NamedTuple):
    """Names and units of a system's signals."""

    states: Sequence[Quantity]
    inputs: Sequence[Quantity]
    outputs: Sequence[Quantity]


def linearize(
    loop: Loop,
    unit: str = "machine",
    *,
    command: float | None = None,
    force: float | None = None,
    time: float | None = None,
    sampled: bool = False,
) -> Linearization:
    """A unit of a loop for small motions about a point: its matrices, with names and units.

    ``machine``: from the command and the force on the rod to all that can be seen of it; in continuous time,
    or ``sampled`` behind the loop's hold and delay, with the force held as the command is. ``controller``:
    from what it measures and the demand to the command. ``loop``: closed, with its sensors, from the demand
    and its derivatives, the force, and a command added to the law's, to all that can be seen. Controller and
    loop are sampled always, as they run.

    The text of the blocks is differentiated exactly; where a kink leaves it no slope, differences stand in,
    and ``inexact`` says which, and how much they may be off. Steps of resolution are left out.

    Args:
        loop: the loop.
        unit: "machine", "controller" or "loop".
        command: u [V] under which the machine has settled; None for that of a steady start, or 0.
        force: on the rod [N]; None for that of the load at t = 0.
        time: [s] linearise at this instant of the loop's run instead, settled or not.
        sampled: the machine from sample to sample.

    Raises:
        ParameterError: there is no such unit or point.

    Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, sec. 4.3 (sampling); Griewank
    and Walther, Evaluating Derivatives, 2008 (exact slopes).
    Fails to say anything of large motions, of limits, and of what happens between samples.
    """
    point = linearization_point(loop, unit, command, force, time)
    return linearization_at(point, unit, sampled=sampled)._replace(loop=loop)


def linearization_point(
    loop: Loop, unit: str, command: float | None, force: float | None, time: float | None
) -> OperatingPoint:
    """The point about which a unit is linearised, as :func:`linearize` has it."""
    loop = checked_loop(loop)
    if unit not in UNITS:
        raise ParameterError("unit", unit, one_of(str(unit), UNITS))
    if time is not None:
        if command is not None or force is not None:
            raise ParameterError("time", time, "is of a run, which has a command and a load of its own")
        return run_point(loop, time)
    if force is not None:
        checked_number(force, "force", Field("N", ""), float)
    find = machine_point if unit == "machine" else operating_point
    return find(loop, command, force)


def linearization_at(point: OperatingPoint, unit: str, *, sampled: bool = False) -> Linearization:
    """A unit of a loop about a point, as :func:`linearize` has it."""
    return sampled_machine_linearization(point) if sampled and unit == "machine" else UNITS[unit](point)


def machine_linearization(point: OperatingPoint) -> Linearization:
    """The machine in continuous time."""
    found = machine_slopes(point)
    states, outputs = state_quantities(point.machine), seen_quantities(point)
    n = len(states)
    table = found.mean
    system = System(table[:n, :n], table[:n, n:], table[n:, :n], table[n:, n:], 0.0)
    inputs = [COMMANDED, LOADED]
    inexact = inexact_slopes(found, [*states, *outputs], [*states, *inputs])
    return named_linearization("machine", system, Names(states, inputs, outputs), inexact)


def sampled_machine_linearization(point: OperatingPoint) -> Linearization:
    """The machine behind its hold and delay, from one sample to the next."""
    parts, found, _ = part_slopes(point)
    names, outputs = all_states(point), seen_quantities(point)
    system = opened_system(point, parts).part([COMMAND, FORCE], list(range(1, 1 + len(outputs))))
    digital = slice(len(values(point.machine)), len(values(point.machine)) + len(values(point.digital)))
    own = np.ones(len(names), dtype=bool)
    own[digital] = False
    machine, inputs = state_quantities(point.machine), [COMMANDED, LOADED]
    inexact = inexact_slopes(found, [*machine, *outputs], [*machine, *inputs])
    left = [name for name, kept in zip(names, own, strict=True) if kept]
    return reduced_linearization("machine", system.kept(own), Names(left, inputs, outputs), inexact)


def controller_linearization(point: OperatingPoint) -> Linearization:
    """The law, from one sample to the next."""
    found = law_slopes(point)
    law = point.digital.controller
    signal = signal_of(point.loop, None)
    states = [
        Quantity(f"controller.{path}", state_field_at(point.loop.controller, law, path, signal).unit)
        for path, _ in leaves(law)
    ]
    n = len(states)
    measured = [
        Quantity(TOLD.get(name, name), field.unit) for name, field in declared_fields(Measurement).items()
    ]
    inputs = [*measured, *demand_quantities(point)]
    asked = [one.name for one in states].index("controller.u")
    table, row = found.mean, found.mean[[asked]]
    system = System(table[:, :n], table[:, n:], row[:, :n], row[:, n:], point.loop.simulation.period)
    inexact = inexact_slopes(found, states, [*states, *inputs])
    return reduced_linearization("controller", system, Names(states, inputs, [COMMANDED]), inexact)


def loop_linearization(point: OperatingPoint) -> Linearization:
    """The closed loop, from one sample to the next."""
    parts, machine, digital = part_slopes(point)
    names, seen = all_states(point), seen_quantities(point)
    inputs = [COMMANDED._replace(name="added_command"), *demand_quantities(point), LOADED]
    states, n = state_quantities(point.machine), len(values(point.machine))
    inexact = [
        *inexact_slopes(machine, [*states, *seen], [*states, COMMANDED, LOADED]),
        *inexact_slopes(
            digital, names[n:], [*names[: n + len(values(point.digital))], *demand_quantities(point), LOADED]
        ),
    ]
    system = close_loop(opened_system(point, parts))
    return reduced_linearization("loop", system, Names(names, inputs, [COMMANDED, *seen]), inexact)


UNITS: dict[str, Callable[[OperatingPoint], Linearization]] = {
    "machine": machine_linearization,
    "controller": controller_linearization,
    "loop": loop_linearization,
}


def reduced_linearization(
    unit: str, system: System, names: Names, inexact: Sequence[InexactSlope]
) -> Linearization:
    """A unit without the states that no input reaches or no output hears, and without inputs of no effect."""
    system, kept = reduced_system(system)
    states = [state for state, stays in zip(names.states, kept, strict=True) if stays]
    moving = (system.b != 0.0).any(axis=0) | (system.d != 0.0).any(axis=0)
    acting = np.flatnonzero(moving).tolist()
    system = system.part(acting, list(range(len(names.outputs))))
    there = {signal.name for signal in (*states, *names.inputs, *names.outputs)}
    heard = [slope for slope in inexact if slope.of in there and slope.by in there]
    left = Names(states, [names.inputs[i] for i in acting], names.outputs)
    return named_linearization(unit, system, left, heard)


def named_linearization(
    unit: str, system: System, names: Names, inexact: Sequence[InexactSlope]
) -> Linearization:
    """A unit with its names; outputs that the machine does not have are left out."""
    there = ((system.c != 0.0).any(axis=1) | (system.d != 0.0).any(axis=1)).tolist()
    system = system.part(list(range(len(names.inputs))), np.flatnonzero(there).tolist())
    outputs = tuple(output for output, moves in zip(names.outputs, there, strict=True) if moves)
    if not all(np.isfinite(matrix).all() for matrix in system[:4]):
        raise ParameterError("unit", unit, "has no slope about its operating point: a number is lost near it")
    return Linearization(unit, tuple(names.states), tuple(names.inputs), outputs, *system, tuple(inexact))


def all_states(point: OperatingPoint) -> list[Quantity]:
    """Those of an opened loop; what the law is told of a delay has a state of its own."""
    whole: LoopState = point.loop.init()
    digital = [
        Quantity(
            path if not path.startswith("hold.") else f"told.{path}",
            state_field_at(point.loop, whole, path).unit,
        )
        for path, _ in leaves(point.digital)
    ]
    hold = state_quantities(point.digital.hold, "hold.")
    return [*state_quantities(point.machine), *digital, *hold, Quantity("hold.command", "V")]


def state_quantities(state: Block, prefix: str = "") -> list[Quantity]:
    """The numbers of a state, which declares them."""
    return [Quantity(prefix + path, field_at(state, path).unit) for path, _ in leaves(state)]


def seen_quantities(point: OperatingPoint) -> list[Quantity]:
    """What is seen of the machine, and what is controlled."""
    seen = [Quantity(name, field.unit) for name, field in declared_fields(MachineOutputs).items()]
    return [*seen, Quantity("controlled", point.loop.controls.declared().unit)]


def demand_quantities(point: OperatingPoint) -> list[Quantity]:
    signal = point.loop.controls.declared()
    fields = declared_fields(Demand).items()
    return [Quantity(f"reference.{name}", field.of(signal).unit) for name, field in fields]


def inexact_slopes(found: Slopes, of: Sequence[Quantity], by: Sequence[Quantity]) -> list[InexactSlope]:
    """The derivatives that are not exact, nor as good as that."""
    places: NDArray[np.int64] = np.argwhere(found.error > CERTAIN * np.abs(found.mean))
    return [
        InexactSlope(of[i].name, by[j].name, float(found.mean[i, j]), float(found.error[i, j]))
        for i, j in places.tolist()
    ]


def run_point(loop: Loop, time: float) -> OperatingPoint:
    """Where a loop is at the last sample up to an instant, before it measures there.

    The instant [s] is from the third sample on.
    """
    refuse_fmus(loop, "linearise it")
    begun = runnable_loop(loop)
    h, duration = begun.simulation.period, begun.simulation.duration
    checked_number(time, "time", Field("s", "", at_least=2.0 * h, at_most=duration), float)
    before = h * (round(time / h + 1e-9) - 1)
    short = begun.simulation._replace(duration=before, record_period=before)
    state = begun.init()
    paths = [path for path, _ in leaves(state)]
    data = quietly(simulate)(begun._replace(simulation=short), record=paths, metrics=[])
    if data["diverged"]:
        raise ParameterError("time", time, f"the run diverged at {float(data['diverged_at']):g} s")
    last = filled(state, iter(float(data[path].values[-1]) for path in paths))
    substeps = begun.simulation.substeps
    substeps = int(data.attrs["substeps"]) if substeps == AUTO else substeps
    held = begun.held(last)
    machine = begun.simulation.integrator.advance(begun, before, begun.machine(last), held, h, substeps)
    now = before + h
    return OperatingPoint(
        begun._replace(controller=smoothed(begun.controller), sensors=smoothed(begun.sensors)),
        float(begun.hold.at(held, np.nextafter(now, before))),
        machine,
        DigitalState(last.sensors, last.controller, last.hold),
        begun.reference.at(now),
        begun.load.force(now),
    )
