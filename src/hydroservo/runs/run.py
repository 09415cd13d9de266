"""One loop in, one trajectory out."""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import Divergence, monitors_of, signals_of, values_of
from hydroservo.control.monitors.group import Usual
from hydroservo.control.monitors.group import named as named_monitors
from hydroservo.control.wiring import believed, wired, with_signal
from hydroservo.core.block import Block, leaves, replace, state_field_at, value_at, values
from hydroservo.core.errors import HydroservoWarning, LoopError, ParameterError
from hydroservo.core.field import Field
from hydroservo.core.group import group
from hydroservo.core.hooks import designed, resting
from hydroservo.core.validation import checked
from hydroservo.cosimulation import ForeignLoad, couple_fmus, first_force, has_fmu
from hydroservo.machine.starts import AsBuilt
from hydroservo.runs.arguments import as_list, checked_loop, checked_mapping
from hydroservo.runs.cautions import warnings_of, warns, with_warning
from hydroservo.runs.cautions.every import loop_cautions, run_cautions
from hydroservo.runs.cautions.records import check_records
from hydroservo.runs.columns import column
from hydroservo.runs.divergence import NOTHING, Loss, first_loss, reach_of, watched_paths
from hydroservo.runs.fitting import compilation, first_state
from hydroservo.runs.steady import check_given, started
from hydroservo.runs.step_sizes import (
    check_substeps,
    checked_steps,
    machine_paths,
    with_exact_delay,
    with_substeps,
)
from hydroservo.runs.trace import Plan, Trace, dataset
from hydroservo.work.notebook_bar import shows_progress

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.engine.kernel import CompiledRun, InterpretedRun, Recording, RunSpec

Progress = Callable[[float], None]  # called with the fraction done, from 0 to 1

CHUNK = 100_000  # integration steps between two looks at the clock and the keyboard
SLOW_CHUNK = 1_000  # in plain Python
LARGEST_TRACE = 2**31  # bytes
MOST_SAMPLES = 2**51  # of a run: up to there each has a number and an instant of its own in doubles


class Mode(NamedTuple):
    """How a kernel is run."""

    compiled: bool
    strict: bool


@warns
@shows_progress
def simulate(
    loop: Loop,
    *,
    record: Sequence[str] | None = None,
    metrics: "Mapping[str, Block] | Sequence[Block] | None" = None,
    compiled: bool = True,
    strict: bool = False,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Simulate a closed loop and return its trajectory and metrics.

    Args:
        loop: the loop; its ``simulation`` block says how long, how often and how finely.
        record: paths of the state to record, such as ``controller.observer.d1``, or of what a monitor
            declares, such as ``disturbance.d1``; all of them if None.
        metrics: the monitors that judge the run, in place of the loop's own; those of
            :func:`~hydroservo.control.metrics.usual` if neither has any. A list, or a mapping of names to
            them.
        compiled: False runs the same text in plain Python, thousands of times slower, for debugging. A loop
            with an FMU in it runs so in any case.
        strict: True rounds after every operation, as plain Python does, and gives its bits; False lets the
            processor fuse a multiplication with an addition, which is faster and rounds once.
        progress: called now and then with the fraction done.

    Returns:
        Dataset with a ``time`` coordinate [s], one variable for each recorded path, one scalar variable
        for each metric, and attributes scenario, hash, version and seed. A run that diverged is a result: its
        ``diverged`` is true, and its attribute ``diverged_by`` names the number that stopped being finite or
        left physical reach (at ``diverged_at``; the trajectory is nan after it). One with automatic substeps
        has the attributes ``substeps`` and ``step_error``; one of which a user should know something, such as
        integration steps too coarse to be trusted, an attribute ``warning`` that says so, a line each.

    Warns:
        HydroservoWarning: each line of that attribute.

    Raises:
        ParameterError: a parameter out of range, times that do not divide, a recorded signal of which the run
            sees nothing, an unknown path in ``record``.
        LoopError: a block that does not fit the loop, or a trace too large to hold.
    """
    mode = Mode(compiled, strict)
    return dataset(traced(with_metrics(checked_loop(loop), metrics), record, mode, progress))


def traced(loop: Loop, record: Sequence[str] | None, mode: Mode, progress: Progress | None) -> Trace:
    """What :func:`simulate` makes a Dataset of, with its warning; nothing says it aloud."""
    run = PreparedRun.of(loop, record, mode)
    loop, recorded = run.loop, check_records(run.loop)
    trace = checked_steps(loop, lambda stepped: run._replace(loop=stepped).trace(progress))
    return with_warning(trace, [*recorded, *loop_cautions(loop), *run_cautions(loop, trace)])


class PreparedRun(NamedTuple):
    """A run of a loop that fits together, and how it is kept; :func:`~hydroservo.prepare_run` makes it."""

    given: Loop
    asked: Loop  # that, complete
    loop: Loop  # that, ready
    state: Block  # in which it begins
    plan: Plan
    wanted: Sequence[str]  # paths of the plan which a user asked for
    mode: Mode

    @classmethod
    def of(cls, given: Loop, record: Sequence[str] | None, mode: Mode) -> Self:
        """A run of a loop, checked and designed."""
        asked, loop = prepare(given)
        state = first_state(loop)
        wanted = paths_of(loop, state) if record is None else tuple(as_list("record", record, "paths"))
        plan = plan_of(loop, state, tuple(dict.fromkeys((*wanted, *machine_paths(loop)))))
        return cls(given, asked, loop, state, plan, wanted, mode)

    def __call__(self, parameters: Mapping[str, float]) -> Trace:
        """Run the loop with other numbers, in SI units by path, such as :func:`~hydroservo.simulate_batch`
        varies.

        Returns:
            Arrays over ``time`` by recorded path and metrics by name, as in the Dataset of a run.

        Raises:
            ParameterError: an unknown path, a value out of its range, or numbers that do not go together.
        """
        for path, value in checked_mapping("parameters", parameters, "paths to numbers").items():
            column(self.asked, path, [value])
        asked, loop = prepare(replace(self.given, parameters))
        return self._replace(asked=asked, loop=loop, state=first_state(loop)).trace()

    def trace(self, progress: Progress | None = None) -> Trace:
        """The run; nothing judges its steps."""
        out = np.full((self.plan.rows, len(self.plan.paths)), np.nan)
        with compilation(self.loop):
            states, loss = run(self.loop, self.state, self.plan, out, self.mode, progress)
        values = values_of(monitors_of(self.loop), states, lost(loss))
        return Trace(self.asked, self.loop, self.plan, self.wanted, out, values, {"diverged_by": loss.path})


def prepare_run(
    loop: Loop,
    *,
    record: Sequence[str] | None = None,
    metrics: "Mapping[str, Block] | Sequence[Block] | None" = None,
    strict: bool = False,
) -> PreparedRun:
    """A loop to be run again and again with other numbers, by a slider or a search::

        run = hs.prepare_run(loop, record=["plant.velocity"])
        for mass in (5.0, 6.0):
            trace = run({"plant.mass": mass})
            trace["time"], trace["plant.velocity"], trace["rms_error"]

    The loop is run once here: its steps are judged, automatic substeps chosen, and warnings given, all for
    the loop as it is. Later runs check their numbers alone, keep these substeps, and have the bits of
    ``simulate`` with them. Arguments, warnings and refusals are those of :func:`simulate`.

    Returns:
        What runs the loop; call it with numbers in SI units by path.
    """
    loop, mode = with_metrics(checked_loop(loop), metrics), Mode(compiled=True, strict=strict)
    judged = traced(loop, record, mode, None)
    for line in warnings_of(judged):
        warnings.warn(line, HydroservoWarning, stacklevel=2)
    return PreparedRun.of(with_substeps(loop, judged.loop.simulation.substeps), record, mode)


def with_metrics(loop: Loop, metrics: "Mapping[str, Block] | Sequence[Block] | None") -> Loop:
    """The loop with these monitors in place of its own; with its own if there are none."""
    return loop if metrics is None else loop._replace(metrics=group(named_monitors(metrics)))


def complete(loop: Loop) -> Loop:
    """The loop with its parameters checked, and with what it leaves open filled in."""
    loop = checked(checked_loop(loop))
    check_substeps(loop)
    return wired(loop)


def prepare(loop: Loop) -> tuple[Loop, Loop]:
    """The loop complete, by which its results are named, and that ready.

    Its plant is at rest then, its start found and its controller designed.
    """
    asked = complete(loop)
    loop = with_exact_delay(asked)
    return asked, started(resting(with_first_force(loop))._replace(controller=designed_law(loop)))


def ready(loop: Loop) -> Loop:
    """The second loop of :func:`prepare`."""
    return prepare(loop)[1]


def designed_law(loop: Loop) -> Block:
    """The controller of a complete loop, designed for it."""
    law = with_signal(loop.controller, loop.controls)
    return checked(designed(law, loop.simulation.period, partial(believed, loop)), "controller")


def trace_size(loop: Loop, record: Sequence[str] | None = None) -> int:
    """Bytes that the recorded trajectory of a loop will take."""
    state = loop.init()
    return plan_size(plan_of(loop, state, record if record is not None else paths_of(loop, state)))


def plan_size(plan: Plan) -> int:
    """Bytes of the recorded numbers and their instants."""
    return 8 * plan.rows * (len(plan.paths) + 1)


def run(
    loop: Loop, state: Block, plan: Plan, out: np.ndarray, mode: Mode, progress: Progress | None
) -> tuple[list[Block], Loss]:
    """What each monitor gathered, and what was lost.

    It goes in chunks, so that progress is seen and an interrupt is heard.
    """
    period = loop.simulation.period
    mode = mode._replace(compiled=mode.compiled and not has_fmu(loop))
    chunk = max(1, (CHUNK if mode.compiled else SLOW_CHUNK) // loop.simulation.substeps)
    with couple_fmus(studied(loop, plan.samples)) as study:
        kernel = kernel_of(study, wanted_of(loop, state, plan.paths), state, mode)
        for first in range(0, plan.samples, chunk):
            last = min(first + chunk, plan.samples)
            done = kernel.advance(first, last, period, plan.stride, out[-(-first // plan.stride) :])
            if done < last:
                lost = first_loss(state, watched_paths(state), values(kernel.state), done * period)
                return gathered(loop, kernel.sums), lost
            if progress is not None:
                progress(last / plan.samples)
    return gathered(loop, kernel.sums), NOTHING


def gathered(loop: Loop, states: Block) -> list[Block]:
    """What each monitor of a loop gathered."""
    from hydroservo.engine.watch import spans_of, state_reader

    numbers, watching = values(states), monitors_of(loop)
    spans = spans_of(watching)
    return [state_reader(monitor.init())(numbers[spans[name]]) for name, monitor in watching.items()]


def lost(loss: Loss) -> Divergence:
    """What the metrics say of a loss."""
    return Divergence(loss is not NOTHING, loss.time)


def kernel_of(
    spec: "RunSpec", wanted: "Recording", state: Block, mode: Mode
) -> "CompiledRun | InterpretedRun":
    """The kernel of a study, at its first sample."""
    from hydroservo.engine.kernel import CompiledRun, InterpretedRun

    if not mode.compiled:
        return InterpretedRun(spec, wanted, state)
    return CompiledRun(spec, wanted, state, strict=mode.strict)


def wanted_of(loop: Loop, state: Block, paths: Sequence[str]) -> "Recording":
    """What a kernel records of a loop, and what it watches."""
    from hydroservo.engine.kernel import Recording
    from hydroservo.engine.watch import monitor_place

    watching = monitors_of(loop)
    signals = signals_of(loop)

    def source(path: str) -> str:
        name, _, own = path.partition(".")
        return f"m.{monitor_place(watching, name)}.{own}" if path in signals else f"s.{path}"

    return Recording(tuple(map(source, paths)), watched_paths(state), reach_of(state))


def studied(loop: Loop, samples: int) -> "RunSpec":
    """All that is constant in a run of so many samples."""
    from hydroservo.engine.kernel import RunSpec
    from hydroservo.engine.watch import monitor_groups

    simulation, watch = loop.simulation, monitor_groups(monitors_of(loop))
    system = loop._replace(metrics=Usual())  # which the kernel does not know
    return RunSpec(system, simulation.integrator, samples - 1, simulation.substeps, watch)


def plan_of(loop: Loop, state: Block, record: Sequence[str]) -> Plan:
    """How a loop is run. What a kernel counts and addresses follows from these numbers alone."""
    simulation = loop.simulation
    ratio = simulation.duration / simulation.period
    if ratio >= MOST_SAMPLES:
        most = f"2^51 periods of {simulation.period:g} s, {MOST_SAMPLES * simulation.period:.3g} s"
        raise ParameterError("simulation.duration", simulation.duration, f"must be less than {most}")
    periods = whole(ratio)
    if periods is None or periods < 1:
        raise ParameterError(
            "simulation.period",
            simulation.period,
            f"must divide the duration of {simulation.duration:g} s into whole periods",
        )
    stride = whole(max(simulation.record_period / simulation.period, 1.0))
    if stride is None:
        raise ParameterError(
            "simulation.record_period",
            simulation.record_period,
            f"must be a whole number of sample periods of {simulation.period:g} s",
        )
    stride = min(stride, periods + 1)  # beyond the end, the first sample alone is recorded
    signals = signals_of(loop)
    fields = tuple(recordable(loop, state, signals, path) for path in record)
    plan = Plan(periods + 1, stride, periods // stride + 1, tuple(record), fields)
    size = plan_size(plan)
    if size > LARGEST_TRACE:
        raise LoopError(
            f"the recorded trajectory would take {size / 2**30:.1f} GiB; "
            f"raise simulation.record_period (now {simulation.record_period:g} s)"
        )
    return plan


def whole(ratio: float) -> int | None:
    """The whole number that a ratio of two times is meant to be, if it is one."""
    nearest = round(ratio) if math.isfinite(ratio) else -1
    return nearest if abs(ratio - nearest) <= 1e-9 * max(nearest, 1) else None


def paths_of(loop: Loop, state: Block) -> tuple[str, ...]:
    """All that can be recorded of a loop's state and of its monitors."""
    return (*(path for path, _ in leaves(state)), *signals_of(loop))


def recordable(loop: Loop, state: Block, signals: Mapping[str, Field], path: str) -> Field:
    """The declaration of the number at a path of a loop's state, or of what a monitor declares."""
    if path in signals:
        return signals[path]
    try:
        value = value_at(state, path)
    except ParameterError as error:
        raise ParameterError("record", path, error.allowed) from None
    if not isinstance(value, float):
        raise ParameterError("record", path, "not a number but a group; name one number in it")
    return state_field_at(loop, state, path)


def with_first_force(loop: Loop) -> Loop:
    """The loop with the force that its load's FMU answers to the start; any other loop as it is."""
    if not isinstance(loop.load, ForeignLoad):
        return loop
    check_given(loop)
    state = AsBuilt(loop.start.given).of(loop.blocks_begin())
    return loop._replace(load=loop.load._replace(held=first_force(loop, state.plant)))
