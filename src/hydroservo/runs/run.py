"""One loop in, one trajectory out."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import monitors_of, values_of
from hydroservo.control.monitors.group import named as named_monitors
from hydroservo.control.wiring import believed, wired, with_signal
from hydroservo.core.block import Block, replace, values
from hydroservo.core.errors import HydroservoWarning
from hydroservo.core.group import group
from hydroservo.core.hooks import designed, resting
from hydroservo.core.validation import checked
from hydroservo.cosimulation import ForeignLoad, couple_fmus, first_force, has_fmu
from hydroservo.machine.starts import AsBuilt
from hydroservo.runs.arguments import as_list, checked_loop, checked_mapping
from hydroservo.runs.cautions import warnings_of, warns, with_warning
from hydroservo.runs.cautions.loop import loop_cautions
from hydroservo.runs.cautions.records import check_records
from hydroservo.runs.cautions.run import run_cautions
from hydroservo.runs.columns import parameter_column
from hydroservo.runs.fitting import compilation, first_state
from hydroservo.runs.kernels import (
    NOTHING,
    Loss,
    Mode,
    divergence_of,
    first_loss,
    gathered_states,
    kernel_of,
    recording_of,
    run_spec,
    watched_paths,
)
from hydroservo.runs.steady import check_given, with_found_start
from hydroservo.runs.step_sizes import (
    check_substeps,
    checked_steps,
    machine_paths,
    with_exact_delay,
    with_substeps,
)
from hydroservo.runs.trace import RunPlan, Trace, plan_of, recordable_paths, run_dataset
from hydroservo.work.notebook_bar import shows_progress

if TYPE_CHECKING:
    import xarray as xr


def with_metrics(loop: Loop, metrics: "Mapping[str, Block] | Sequence[Block] | None") -> Loop:
    """The loop with these monitors in place of its own; with its own if there are none."""
    return loop if metrics is None else loop._replace(metrics=group(named_monitors(metrics)))


def complete_loop(loop: Loop) -> Loop:
    """The loop with its parameters checked, and with what it leaves open filled in."""
    loop = checked(checked_loop(loop))
    check_substeps(loop)
    return wired(loop)


def prepare_loop(loop: Loop) -> tuple[Loop, Loop]:
    """The loop complete, by which its results are named, and that ready.

    Its plant is at rest then, its start found and its controller designed.
    """
    asked = complete_loop(loop)
    loop = with_exact_delay(asked)
    return asked, with_found_start(resting(with_first_force(loop))._replace(controller=designed_law(loop)))


def runnable_loop(loop: Loop) -> Loop:
    """The second loop of :func:`prepare_loop`."""
    return prepare_loop(loop)[1]


def designed_law(loop: Loop) -> Block:
    """The controller of a complete loop, designed for it."""
    law = with_signal(loop.controller, loop.controls)
    return checked(designed(law, loop.simulation.period, partial(believed, loop)), "controller")


def with_first_force(loop: Loop) -> Loop:
    """The loop with the force that its load's FMU answers to the start; any other loop as it is."""
    if not isinstance(loop.load, ForeignLoad):
        return loop
    check_given(loop)
    state = AsBuilt(loop.start.given).of(loop.blocks_begin())
    return loop._replace(load=loop.load._replace(held=first_force(loop, state.plant)))


RunProgress = Callable[[float], None]  # called with the fraction done, from 0 to 1

CHUNK = 100_000  # integration steps between two looks at the clock and the keyboard
SLOW_CHUNK = 1_000  # in plain Python


@warns
@shows_progress
def simulate(
    loop: Loop,
    *,
    record: Sequence[str] | None = None,
    metrics: "Mapping[str, Block] | Sequence[Block] | None" = None,
    compiled: bool = True,
    strict: bool = False,
    progress: RunProgress | None = None,
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
    return run_dataset(run_trace(with_metrics(checked_loop(loop), metrics), record, mode, progress))


def run_trace(loop: Loop, record: Sequence[str] | None, mode: Mode, progress: RunProgress | None) -> Trace:
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
    plan: RunPlan
    wanted: Sequence[str]  # paths of the plan which a user asked for
    mode: Mode

    @classmethod
    def of(cls, given: Loop, record: Sequence[str] | None, mode: Mode) -> Self:
        """A run of a loop, checked and designed."""
        asked, loop = prepare_loop(given)
        state = first_state(loop)
        wanted = (
            recordable_paths(loop, state) if record is None else tuple(as_list("record", record, "paths"))
        )
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
            parameter_column(self.asked, path, [value])
        asked, loop = prepare_loop(replace(self.given, parameters))
        return self._replace(asked=asked, loop=loop, state=first_state(loop)).trace()

    def trace(self, progress: RunProgress | None = None) -> Trace:
        """The run; nothing judges its steps."""
        out = np.full((self.plan.rows, len(self.plan.paths)), np.nan)
        with compilation(self.loop):
            states, loss = run_kernel(self.loop, self.state, self.plan, out, self.mode, progress)
        values = values_of(monitors_of(self.loop), states, divergence_of(loss))
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
    judged = run_trace(loop, record, mode, None)
    for line in warnings_of(judged):
        warnings.warn(line, HydroservoWarning, stacklevel=2)
    return PreparedRun.of(with_substeps(loop, judged.loop.simulation.substeps), record, mode)


def run_kernel(
    loop: Loop, state: Block, plan: RunPlan, out: np.ndarray, mode: Mode, progress: RunProgress | None
) -> tuple[list[Block], Loss]:
    """What each monitor gathered, and what was lost.

    It goes in chunks, so that progress is seen and an interrupt is heard.
    """
    period = loop.simulation.period
    mode = mode._replace(compiled=mode.compiled and not has_fmu(loop))
    chunk = max(1, (CHUNK if mode.compiled else SLOW_CHUNK) // loop.simulation.substeps)
    with couple_fmus(run_spec(loop, plan.samples)) as study:
        kernel = kernel_of(study, recording_of(loop, state, plan.paths), state, mode)
        for first in range(0, plan.samples, chunk):
            last = min(first + chunk, plan.samples)
            done = kernel.advance(first, last, period, plan.stride, out[-(-first // plan.stride) :])
            if done < last:
                lost = first_loss(state, watched_paths(state), values(kernel.state), done * period)
                return gathered_states(loop, kernel.sums), lost
            if progress is not None:
                progress(last / plan.samples)
    return gathered_states(loop, kernel.sums), NOTHING
