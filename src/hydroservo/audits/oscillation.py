"""An oscillation that a run shows, and what keeps it up: each cause is switched off by itself."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Annotated, Any, NamedTuple

from hydroservo.audits.monitors import swing
from hydroservo.control.controlled import Command
from hydroservo.control.controllers.dither import without_dither
from hydroservo.control.error_dynamics import ExplicitReaching, ImplicitReaching, SmoothReaching
from hydroservo.control.loop import Loop
from hydroservo.control.monitors import Oscillation
from hydroservo.control.monitors.oscillation import END
from hydroservo.control.observers import BoundaryLayer, Explicit, Implicit
from hydroservo.control.wiring import wired
from hydroservo.core.block import Block, Field, is_block, leaves, replace
from hydroservo.core.errors import HydroservoError
from hydroservo.core.group import nested
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.linear.onset import with_amplified_command
from hydroservo.machine.loads.later import LaterLoad
from hydroservo.machine.starts import AsBuilt
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import runnable_loop, simulate
from hydroservo.runs.step_sizes import at_period

FINE_BITS = 32  # the most that a converter has
FINE = 1e-15  # [m] a resolution that nothing tells from none
LITTLE = 1e-3  # what is left of friction, whose laws do not allow none
SHORTER = 0.25  # of the sample period

Change = Callable[[float], float]
OSCILLATION = Oscillation()
LOST = 0.7  # of its amplitude, by which an oscillation has died out
LONGER = 4.0  # times its duration, for which a loop is run that is too short to tell
CYCLES = 1000.0  # for which a loop goes on at the most


class Cause(NamedTuple):
    """One kind of cause.

    Those of one name are tried in turn, until one ends the oscillation.
    """

    name: str  # of the kind
    phrase: str  # how the loop is without it, as in "the oscillation dies out without integral action"
    without: Callable[[Loop], Loop | None]  # the loop without it; None where it has none
    scale: float = 1.0  # of the command that remains by that alone


def field_change(place: str, changes: Mapping[str, Change]) -> Callable[[Loop], Loop | None]:
    """A loop with the fields of these names changed, wherever they are in a part of it."""

    def without(loop: Loop) -> Loop | None:
        found: dict[str, float] = {}
        for path, value in leaves(loop):
            if not path.startswith(f"{place}.") or ".model." in path or type(value) not in (int, float):
                continue
            for name, change in changes.items():
                new = type(value)(change(value))
                if path.endswith((f".{name}", f"_{name}")) and new != value and math.isfinite(value):
                    found[path] = new
        changed: Loop | None = replace(loop, found) if found else None
        return changed

    return without


def with_shorter_period(loop: Loop) -> Loop:
    """The loop at a shorter sample period and delay."""
    return at_period(loop, SHORTER * loop.simulation.period)


def with_still_command(loop: Loop) -> Loop | None:
    """The loop without dither; None where it has none."""
    law = without_dither(loop.controller)
    changed: Loop | None = None if law == loop.controller else loop._replace(controller=law)
    return changed


def with_implicit_steps(loop: Loop) -> Loop | None:
    """The loop with implicit steps where its law switches at the sample; None where it does not."""
    law = implicit_twin(loop.controller)
    changed: Loop | None = None if law is loop.controller else loop._replace(controller=law)
    return changed


def implicit_twin(block: Block) -> Any:
    """A block with implicit steps in place of explicit and smoothed ones, in it and in blocks in it."""
    if isinstance(block, Explicit | BoundaryLayer):
        return Implicit()
    if isinstance(block, ExplicitReaching | SmoothReaching):
        return ImplicitReaching()
    parts = {name: (part, implicit_twin(part)) for name, part in block._asdict().items() if is_block(part)}
    changed = {name: new for name, (old, new) in parts.items() if new is not old}
    return block._replace(**changed) if changed else block


def to_zero(_: float) -> float:
    return 0.0


def to_little(value: float) -> float:
    return LITTLE * value


def without_overlap(lap: float) -> float:
    return min(lap, 0.0)


FRICTION = {
    "coulomb": to_little,
    "breakaway": to_little,
    "bristle_stiffness": to_little,  # so that bristles bend as far, and what they do is as fast
    "bristle_damping": to_little,
}
EDGES = {
    "lap": without_overlap,
    "extra_lap_pa": without_overlap,
    "extra_lap_at": without_overlap,
    "extra_lap_pb": without_overlap,
    "extra_lap_bt": without_overlap,
}

CAUSES = (
    Cause(
        "integral action", "without integral action", field_change("controller", {"integral_gain": to_zero})
    ),
    Cause("dry friction", "without dry friction", field_change("plant", FRICTION)),
    Cause(
        "valve hysteresis", "without the valve's hysteresis", field_change("valve", {"hysteresis": to_zero})
    ),
    Cause("valve overlap", "without the valve's overlap", field_change("valve", EDGES)),
    Cause(
        "overlap compensation",
        "without compensation of the overlap",
        field_change("controller", {"extend_overlap": to_zero, "retract_overlap": to_zero}),
    ),
    Cause(
        "converter steps",
        "without the steps of the command's converter",
        field_change("controller", {"bits": lambda _: FINE_BITS}),
    ),
    Cause(
        "sensor steps",
        "without the steps of the sensors",
        field_change("sensors", {"resolution": lambda _: FINE, "bits": to_zero}),
    ),
    Cause("dither", "without the dither", with_still_command),
    Cause("sensor noise", "without the sensors' noise", field_change("sensors", {"noise": to_zero})),
    Cause("switching", "with implicit steps in place of its switching", with_implicit_steps),
    Cause("sampling", "at a quarter of the sample period and delay", with_shorter_period),
    Cause("gain", "at half the gain", partial(with_amplified_command, factor=0.5), 0.5),
    Cause("gain", "at a tenth of the gain", partial(with_amplified_command, factor=0.1), 0.1),
)


@role(Reference)
class LaterDemand(NamedTuple):
    """A demand that begins where another is at an instant: r(t + t_0).

    Source: a definition.
    Fails where it is asked for an instant before 0.
    """

    reference: Reference
    begins: Annotated[float, Field("s", "the instant t_0", at_least=0)]

    def at(self, t: float) -> Demand:
        return self.reference.at(t + self.begins)


class Remains(NamedTuple):
    """What is left of an oscillation without one cause."""

    cause: Annotated[str, Field("", "what is switched off")]
    phrase: Annotated[str, Field("", "how the loop is without it")]
    command: Annotated[float, Field("V", "amplitude of the command then; nan if there is no such run")]
    ends: Annotated[bool, Field("", "whether the oscillation dies out")]


class SustainedOscillation(NamedTuple):
    """A sustained oscillation of a run; amplitudes of 0 if there is none, nan if it is too short to tell."""

    amplitude: Annotated[float, Field("y", "amplitude of the {y}")]
    unit: Annotated[str, Field("", "of that amplitude")]
    command: Annotated[float, Field("V", "amplitude of the command")]
    frequency: Annotated[float, Field("Hz", "frequency")]
    growth: Annotated[float, Field("", "growth from cycle to cycle")]
    longer: Annotated[float, Field("s", "length of a longer run that tells; 0: the loop's own does")] = 0.0
    remains: tuple[Remains, ...] = ()

    @property
    def oscillates(self) -> bool:
        return self.command > 0.0

    @property
    def causes(self) -> tuple[Remains, ...]:
        """Those without which it dies out, each by itself."""
        return tuple(one for one in self.remains if one.ends)

    def numbers(self) -> dict[str, Any]:
        """All of it, in SI units."""
        remains = [one._asdict() for one in self.remains]
        return {**self._asdict(), "causes": [one.cause for one in self.causes], "remains": remains}


def sustained_oscillation(loop: Loop, run: Any) -> SustainedOscillation | None:
    """The sustained oscillation of a run, and what keeps it up.

    The machine and its law go on from where the run has ended, in the midst of the oscillation, with the
    demand and the load that follow; once as they are, and once without each cause that the loop has. A cause
    is what ends it there by 70 % or more. What merely sets an oscillation off is none: a run from the start
    without that would rest, and this one goes on. Where the oscillation does not last beyond the run, for the
    demand has changed, the run is repeated from its start instead. A run that is too short to tell is
    repeated, four times as long.

    Args:
        loop: the loop.
        run: of it, with the metrics of :class:`~hydroservo.control.monitors.Oscillation`.

    Returns:
        None of an open loop, and where the run diverged.

    Fails to tell causes of which each can keep it up by itself: without either of two it goes on. It cannot
    switch off the integral action of observers, and of laws whose gains are computed.
    """
    if isinstance(loop.controls, Command) or bool(run["diverged"]):
        return None
    found = oscillation_in(loop, run)
    if math.isnan(found.command):
        given = loop.simulation
        loop = loop._replace(simulation=given._replace(duration=LONGER * given.duration))
        try:
            run = quietly(simulate)(loop, record=[], metrics=[OSCILLATION])
        except HydroservoError:  # a recorded demand that ends
            return found
        if bool(run["diverged"]):
            return found
        found = oscillation_in(loop, run)._replace(longer=loop.simulation.duration)
    return found._replace(remains=remains_of_causes(loop, found)) if found.oscillates else found


def oscillation_in(loop: Loop, run: Any) -> SustainedOscillation:
    """The oscillation that a run shows."""
    values = [float(run[f"oscillation_{name}"]) for name in ("amplitude", "command", "frequency", "growth")]
    amplitude, command, frequency, growth = values
    return SustainedOscillation(amplitude, loop.controls.declared().unit, command, frequency, growth)


def remains_of_causes(loop: Loop, shown: SustainedOscillation) -> tuple[Remains, ...]:
    """What is left of an oscillation without each of the causes that a loop has."""
    begun = wired(loop)
    size = 0.0
    with suppress(HydroservoError):  # a state, as it is then, that no run may begin in
        going = continued_loop(begun, shown.frequency)
        size = remaining_amplitude(going)
    if not size > (1.0 - LOST) * shown.command:
        going, size = begun, shown.command
    found: list[Remains] = []
    for cause in CAUSES:
        ended = any(one.cause == cause.name and one.ends for one in found)
        one = None if ended else remains_without(going, cause, size)
        found += [] if one is None else [one]
    return tuple(found)


def continued_loop(loop: Loop, frequency: float) -> Loop:
    """The loop from the end of its run on, for the same time or a thousand cycles."""
    period, duration = loop.simulation.period, loop.simulation.duration
    whole = period * round(duration / period)
    sparse = loop._replace(simulation=loop.simulation._replace(record_period=whole))
    run = quietly(simulate)(sparse, metrics=[])
    state = {path: float(run[path][-1]) for path, _ in leaves(runnable_loop(loop).init()) if path in run}
    known = {path: value for path, value in state.items() if math.isfinite(value)}
    span = period * math.ceil(min(duration, CYCLES / frequency) / period)
    end = float(run["time"][-1])
    return loop._replace(
        simulation=loop.simulation._replace(duration=span, record_period=period),
        start=AsBuilt(nested(known)),
        reference=LaterDemand(loop.reference, end),
        load=LaterLoad(loop.load, end),
    )


def remains_without(loop: Loop, cause: Cause, size: float) -> Remains | None:
    """What is left of a swing of ``size`` [V] without a cause; None where the loop has none of that kind."""
    changed = cause.without(loop)
    if changed is None:
        return None
    try:
        command = remaining_amplitude(changed)
    except HydroservoError:  # a law that has no design at the shorter period
        command = math.nan
    return Remains(cause.name, cause.phrase, command, command <= (1.0 - LOST) * cause.scale * size)


def remaining_amplitude(loop: Loop) -> float:
    """The amplitude of the command at the end of a run [V]; nan where it diverged.

    It is that of a sustained oscillation; where the run is too short to tell, that of all that is no trend.
    """
    run = quietly(simulate)(loop, record=["controller.u"], metrics=[OSCILLATION])
    if bool(run["diverged"]):
        return math.nan
    command = float(run["oscillation_command"])
    if math.isfinite(command):
        return command
    late = run["time"] >= (1.0 - END) * loop.simulation.duration
    return swing(run["controller.u"].to_numpy()[late.to_numpy()], loop.simulation.record_period).amplitude
