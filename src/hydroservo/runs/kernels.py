"""The kernel of a run: compiled or not, what it records, and which number of its state was lost first."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import Divergence, monitors_of, signals_of
from hydroservo.control.monitors.group import Usual
from hydroservo.core.block import Block, leaves, values

if TYPE_CHECKING:
    from hydroservo.engine.kernel import CompiledRun, InterpretedRun, Recording, RunSpec

BEYOND = "left physical reach, beyond"
ORDER = ("reference", "sensors", "controller", "hold", "load")  # from cause to effect; last the machine
REACH: Mapping[str, tuple[float, str]] = {  # of numbers of a machine, far beyond any that is built
    "plant.velocity": (100.0, "100 m/s"),
    "plant.pressure_a": (1e9, "10,000 bar"),
    "plant.pressure_b": (1e9, "10,000 bar"),
}


class Loss(NamedTuple):
    """The number that a run lost, and when."""

    path: str  # and, where it was finite, what it went beyond
    time: float  # instant of the sample [s]


NOTHING = Loss("nothing", math.nan)


def watched_paths(state: Block) -> tuple[str, ...]:
    """The numbers of a loop's state that must stay finite, from its first state.

    One that is nan there says that nothing is known yet, as of a signal that nothing measures, and may be so
    again.
    """
    return tuple(path for path, value in leaves(state) if math.isfinite(value))


def state_reaches(state: Block) -> tuple[tuple[str, float], ...]:
    """How large some numbers of a loop's state may be, by path: velocity [m/s] and pressures [Pa]."""
    known = {path for path, _ in leaves(state)}
    return tuple((path, most) for path, (most, _) in REACH.items() if path in known)


def first_loss(state: Block, watched: Sequence[str], numbers: Sequence[float], time: float) -> Loss:
    """The first number of a state that is lost, causes before effects."""
    values = dict(zip((path for path, _ in leaves(state)), numbers, strict=True))
    lost = [path for path in watched if not math.isfinite(values[path])]
    if lost:
        return Loss(min(lost, key=place_in_sample), time)
    path = next(path for path, most in state_reaches(state) if abs(values[path]) > most)
    return Loss(f"{path} {BEYOND} {REACH[path][1]}", time)


def place_in_sample(path: str) -> int:
    """How far from the first cause a number is."""
    part = path.partition(".")[0]
    return ORDER.index(part) if part in ORDER else len(ORDER)


class Mode(NamedTuple):
    """How a kernel is run."""

    compiled: bool
    strict: bool


def gathered_states(loop: Loop, states: Block) -> list[Block]:
    from hydroservo.engine.watch import spans_of, state_reader

    numbers, watching = values(states), monitors_of(loop)
    spans = spans_of(watching)
    return [state_reader(monitor.init())(numbers[spans[name]]) for name, monitor in watching.items()]


def divergence_of(loss: Loss) -> Divergence:
    """What the metrics say of a loss."""
    return Divergence(loss is not NOTHING, loss.time)


def kernel_of(
    study: "RunSpec", wanted: "Recording", state: Block, mode: Mode
) -> "CompiledRun | InterpretedRun":
    """The kernel of a study, at its first sample."""
    from hydroservo.engine.kernel import CompiledRun, InterpretedRun

    if not mode.compiled:
        return InterpretedRun(study, wanted, state)
    return CompiledRun(study, wanted, state, strict=mode.strict)


def recording_of(loop: Loop, state: Block, paths: Sequence[str]) -> "Recording":
    """What a kernel records of a loop, and what it watches."""
    from hydroservo.engine.kernel import Recording
    from hydroservo.engine.watch import monitor_place

    watching = monitors_of(loop)
    signals = signals_of(loop)

    def source(path: str) -> str:
        name, _, own = path.partition(".")
        return f"m.{monitor_place(watching, name)}.{own}" if path in signals else f"s.{path}"

    return Recording(tuple(map(source, paths)), watched_paths(state), state_reaches(state))


def run_spec(loop: Loop, samples: int) -> "RunSpec":
    """All that is constant in a run of so many samples."""
    from hydroservo.engine.kernel import RunSpec
    from hydroservo.engine.watch import monitor_groups

    simulation, watch = loop.simulation, monitor_groups(monitors_of(loop))
    system = loop._replace(metrics=Usual())  # which the kernel does not know
    return RunSpec(system, simulation.integrator, samples - 1, simulation.substeps, watch)
