"""A scenario's machine under the inputs of a log, how finely it is followed, and what it would have shown."""

import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import AUTO, Loop
from hydroservo.core.block import Block, leaves, replace
from hydroservo.core.group import group, nested
from hydroservo.core.roles import at_samples
from hydroservo.core.signals import MachineOutputs
from hydroservo.core.time_series import TimeSeries
from hydroservo.core.validation import checked
from hydroservo.cosimulation import refuse_fmus
from hydroservo.identification.log import COMMAND, EXTERNAL_FORCE
from hydroservo.identification.observer import LogObserver, corrector
from hydroservo.identification.segments import Segment
from hydroservo.limits.command import Playback
from hydroservo.machine import loads
from hydroservo.machine.loads.later import LaterLoad
from hydroservo.machine.starts import AsBuilt, Steady
from hydroservo.runs.cautions import quietly
from hydroservo.runs.columns import Columns, checked_columns, start_columns
from hydroservo.runs.fitting import compilation, first_state
from hydroservo.runs.kernels import recording_of, run_spec
from hydroservo.runs.run import runnable_loop, simulate
from hydroservo.runs.step_sizes import command_parts, with_substeps

if TYPE_CHECKING:
    from hydroservo.engine.lanes import CompiledLanes

BEGUN = "load.begins"  # where a recorded force, which the sensors' delay reached too, is put right
GIVEN = "start.given."
LOAD = "load."

Traces = NDArray[np.float64]  # shape (samples, signals, runs)
TRIED = 1.0  # s of a log, after which the steps that it takes are known
COARSE = 1e-4  # tolerance of a search's steps: a tenth of what its first fit tries to get below


class Experiment(NamedTuple):
    """What is run to say what a segment would have shown."""

    segment: Segment  # the stretch of a log
    given: Loop  # the loop that plays it, its plant's start open where the log says nothing
    loop: Loop  # the same, ready to run
    # the states in which it begins that the log shows, by their path in :attr:`loop`
    start: Mapping[str, float]
    varied: tuple[str, ...]  # paths that may differ between runs; one kernel serves all sets of them
    observer: LogObserver | None = None  # what lets it follow the segment; None simulates it
    # of those that it does not show, the scenario's value and how far it moves, by path
    unseen: Mapping[str, tuple[float, float]] = MappingProxyType({})

    @property
    def whole(self) -> int | None:
        """About how many samples its observer takes signals to be late; None of a simulation."""
        return None if self.observer is None else self.observer.whole


def experiment(
    loop: Loop, segment: Segment, varied: Sequence[str], substeps: int, moving: bool = False
) -> Experiment:
    """A loop that plays a segment.

    It starts in the states that the log shows, from its first samples, and else where the scenario does.

    Paths in ``varied`` may differ between runs, but for those of a load that a recorded force replaces; with
    ``moving``, so may states that the log does not show.
    """
    refuse_fmus(loop, "identify it")
    played = playback_loop(loop, segment, substeps)
    known = first_states(runnable_loop(played), segment)
    every = dict(moving_states(runnable_loop(played))) | known if moving else known
    fixed = played._replace(start=AsBuilt(nested(every | given_states(runnable_loop(played), every))))
    start = {f"{GIVEN}{path}": value for path, value in known.items()}
    begins = [f"{GIVEN}{path}" for path in every]
    if EXTERNAL_FORCE not in segment.inputs:
        return Experiment(segment, fixed, runnable_loop(fixed), start, (*varied, *begins))
    others = (path for path in varied if not path.startswith(LOAD))
    return Experiment(segment, fixed, runnable_loop(fixed), start, (*others, *begins, BEGUN))


def played_path(path: str) -> str:
    """Where a number of a loop lies once the loop plays a segment."""
    return f"{LOAD}{path}" if path.startswith(LOAD) else path


def playback_loop(loop: Loop, segment: Segment, substeps: int) -> Loop:
    """The loop with a recorded command in place of its law, and a recorded force in that of its load."""
    simulation = loop.simulation._replace(
        duration=segment.period * (segment.samples - 1),
        period=segment.period,
        record_period=segment.period,
        substeps=substeps,
    )
    if EXTERNAL_FORCE in segment.inputs:
        series = TimeSeries.from_samples(segment.time - segment.start, segment.inputs[EXTERNAL_FORCE])
        load: Block = LaterLoad(loads.Recorded(series))
    else:
        load = LaterLoad(loop.load, segment.start)
    law = Playback(np.ascontiguousarray(segment.inputs[COMMAND]))
    return loop._replace(simulation=simulation, controller=law, load=load, metrics=group({"seen": Seen()}))


def first_states(loop: Loop, segment: Segment) -> dict[str, float]:
    """The plant's states that were measured, at the start, by path in the loop's state."""
    own = loop.plant.init()._asdict()
    found = {}
    for name, values in segment.measured.items():
        if name in own and np.isfinite(values).any():
            found[f"plant.{name}"] = first_value(values)
    return found


def moving_states(loop: Loop) -> Iterator[tuple[str, float]]:
    """The states of what moves the oil and the rod, but the position, at the scenario's start."""
    for path, value in leaves(loop.init()):
        moves = path.startswith(("plant.", "valve.", "drive.")) and path != "plant.position"
        if moves and isinstance(value, float) and np.isfinite(value):
            yield path, value


def first_value(values: NDArray[np.float64]) -> float:
    """A signal at its first sample, from a straight line through its first eight that are there."""
    places = np.flatnonzero(np.isfinite(values))[:8]
    if places.size < 3:
        return float(values[places[0]])
    return float(np.polyval(np.polyfit(places, values[places], 1), 0.0))


def given_states(loop: Loop, known: Mapping[str, float]) -> dict[str, float]:
    """The states that the scenario's own start gives or finds, but for those that are known."""
    pairs = leaves(loop.start.given) if isinstance(loop.start, AsBuilt | Steady) else ()
    return {path: value for path, value in pairs if path not in known and not path.startswith("controller")}


def predict_traces(
    one: Experiment,
    columns: Mapping[str, NDArray[np.float64]],
    threads: int,
    offsets: Mapping[str, NDArray[np.float64]] | None = None,
    late: NDArray[np.float64] | None = None,
) -> Traces:
    """What the machine would have shown with each of some sets of parameters.

    Columns, offsets of the sensors that an observer follows and the samples by which it is late have shape
    (runs,); where a path has no column, the loop's own value holds. The result has shape (samples, signals,
    runs), the signals those of MachineOutputs, nan once a run is lost.
    """
    from hydroservo.engine.lanes import LANES, monitor_traces

    samples, period = one.segment.samples, one.segment.period
    size = next(iter(columns.values())).size
    with compilation(one.loop):
        kernel, started = kernel_for(one, columns)

        def part(first: int) -> Traces:
            own, reads = (
                {key: values[first : first + LANES] for key, values in rows.items()}
                for rows in (started, offsets or {})
            )
            after = None
            if one.observer is not None and late is not None:
                after = corrector(one.observer, kernel, reads, late[first : first + LANES])
            return monitor_traces(kernel, own, samples, period, after)[:, :, : min(LANES, size - first)]

        firsts = range(0, size, LANES)
        if len(firsts) == 1:
            return part(0)
        with ThreadPoolExecutor(threads) as pool:
            return np.concatenate(list(pool.map(part, firsts)), axis=2)


def kernel_for(
    one: Experiment, columns: Mapping[str, NDArray[np.float64]]
) -> tuple["CompiledLanes", Columns]:
    """The kernel of an experiment, and all that its runs do not share."""
    from hydroservo.engine.lanes import CompiledLanes

    started, state = run_columns(one, columns), first_state(one.loop)
    study, wanted = run_spec(one.loop, one.segment.samples), recording_of(one.loop, state, ())
    return CompiledLanes(study, wanted, state, tuple(started), strict=False), started


def run_columns(one: Experiment, columns: Mapping[str, NDArray[np.float64]]) -> Columns:
    """All columns by which the runs of an experiment differ, their starting states included."""
    own = dict(leaves(one.loop))
    size = next(iter(columns.values())).size
    every = {path: columns.get(path, np.full(size, own[path])) for path in one.varied} | dict(columns)
    given = checked_columns(one.loop, every)
    return given | start_columns(checked(one.given), given)


class Nothing(NamedTuple):
    """No metric."""


@at_samples
class Seen(NamedTuple):
    """The machine's outputs at each sample, for whoever looks at them before the next.

    Source: a definition.
    Fails to be a metric of a run: it keeps nothing but the last sample.
    """

    def init(self) -> MachineOutputs:
        return MachineOutputs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, m: MachineOutputs, loop: Block, s: Block, t: float, dt: float) -> MachineOutputs:
        return loop.seen(s, loop.load.force(t))  # type: ignore[no-any-return]

    def values(self, m: MachineOutputs) -> Nothing:
        return Nothing()


def first_steps(loop: Loop, segment: Segment) -> int:
    """The number of integration steps between two samples of a log, to begin a search with.

    As many in a second as the scenario has, at least; with automatic ones, as many as the log's beginning
    takes with the scenario's own machine, coarsely.
    """
    simulation = loop.simulation
    one = experiment(loop, segment, (), AUTO)
    if simulation.substeps == AUTO:
        return automatic_steps(one, {}, COARSE)
    wanted = math.ceil(simulation.substeps * segment.period / simulation.period * (1.0 - 1e-9))
    parts = command_parts(one.loop)
    return -(-wanted // parts) * parts


def automatic_steps(one: Experiment, numbers: Mapping[str, float], tolerance: float) -> int:
    """The number of automatic steps between two samples that a machine takes over a log's beginning.

    The tolerance is relative; the scenario's own applies where it is larger.
    """
    simulation, segment = one.given.simulation, one.segment
    samples = max(min(segment.samples, round(TRIED / segment.period)), 2)
    brief = simulation._replace(
        duration=segment.period * (samples - 1), substeps=AUTO, tolerance=max(tolerance, simulation.tolerance)
    )
    loop: Loop = replace(one.given._replace(simulation=brief), numbers)
    return int(quietly(simulate)(loop, record=()).attrs["substeps"])


def with_experiment_steps(one: Experiment, substeps: int) -> Experiment:
    """The experiment with so many steps between two samples."""
    return one._replace(given=with_substeps(one.given, substeps), loop=with_substeps(one.loop, substeps))
