"""A whole loop with the monitors that a page shows, from one sample to the next."""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from hydroservo.control.controlled import Command
from hydroservo.control.loop import Loop
from hydroservo.control.metrics import monitors_of
from hydroservo.control.monitors import CommandEffort, StepResponse, TrackingError
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.engine.flat import checker, constructor, text_function
from hydroservo.engine.kernel import mover
from hydroservo.engine.watch import End, MonitorGroups, MonitorPair, listener, monitor_place
from hydroservo.export.parts import PERIOD, block_of
from hydroservo.export.unit import Part
from hydroservo.runs.kernels import run_spec, state_reaches, watched_paths
from hydroservo.runs.run import with_metrics

METRICS, WATCH = "metrics", "watch"  # fields of the state


class WatchedState(NamedTuple):
    """A loop at a sample whose controller has just run, what its monitors gathered, and what it comes to."""

    loop: Block
    watch: MonitorGroups
    metrics: MonitorGroups
    holds: Annotated[float, Field("", "1 while the run goes on, 0 where it is lost")]
    sample: Annotated[float, Field("", "number of samples since the start")]


def page_monitors(loop: Loop) -> list[Block]:
    """The monitors of a page: the command's, and where there is an error those of the error."""
    errors = [] if isinstance(loop.controls, Command) else [TrackingError(), StepResponse()]
    return [*errors, CommandEffort()]


def metric_places(loop: Loop) -> list[str]:
    """Where each metric of a loop is in its :class:`WatchedState`, in the order of the metrics."""
    watching = monitors_of(loop)
    return [
        f"{METRICS}.{monitor_place(watching, name)}.{own}"
        for name, monitor in watching.items()
        for own in monitor.values(monitor.init())._fields
    ]


def watched_loop(loop: Loop, part: Part) -> Block:
    """The block of a whole loop that steps as a run does, and whose monitors hear what they hear there.

    Where a run is lost, the monitors have heard all up to there, and the numbers of the loop mean nothing.
    """
    loop = with_metrics(loop, page_monitors(loop))
    study, bare, first = run_spec(loop, 1), block_of(loop, part), loop.init()
    move, judge = mover(study), judgement(study.watch)
    hear_sample, hear_step = listener(study.watch.samples), listener(study.watch.steps)
    begin = constructor("begin()", study.watch.init(), lambda _, value: repr(value))
    finite = checker(watched_paths(first), dict(state_reaches(first)))

    class WatchedLoop(NamedTuple):
        """A whole loop with its monitors, from one sample to the next."""

        loop: Loop
        watch: MonitorGroups
        period: Annotated[float, PERIOD]

        def init(self) -> WatchedState:
            """The first sample."""
            m, watch, before = self.loop, self.watch, begin()
            s = m.sample(m.init(), 0.0, self.period)
            heard = hear_sample(watch.samples, before.samples, m, s, 0.0, self.period)
            last = hear_step(watch.steps, before.steps, m, s, 0.0, 0.0)
            found = judge(watch, MonitorGroups(heard, last))
            return WatchedState(s, MonitorGroups(heard, before.steps), found, 1.0, 0.0)

        def step(self, state: WatchedState) -> WatchedState:
            """The machine goes on to the next sample, and the controller runs there."""
            m, watch, before, dt = self.loop, self.watch, state.watch, self.period
            integrator, substeps = m.simulation.integrator, m.simulation.substeps
            now = state.sample * dt
            x, steps = move(m, integrator, watch.steps, before.steps, state.loop, now, dt, substeps)
            moved = m.with_machine(state.loop, x)
            holds, sample = finite(moved), state.sample + 1.0
            t = sample * dt
            s = m.sample(moved, t, dt)
            heard = ops.where(holds, hear_sample(watch.samples, before.samples, m, s, t, dt), before.samples)
            last = ops.where(holds, hear_step(watch.steps, steps, m, s, t, 0.0), steps)
            found = judge(watch, MonitorGroups(heard, last))
            return WatchedState(s, MonitorGroups(heard, steps), found, ops.where(holds, 1.0, 0.0), sample)

    return WatchedLoop(bare.loop, study.watch, bare.period)


def judgement(watch: MonitorGroups) -> Callable[..., Any]:
    """A function ``judge(w, m)`` that gives what every monitor comes to."""

    def text(part: Block, path: str) -> str:
        if not isinstance(part, MonitorPair):
            return "End()"
        return f"Pair(w.{path}.first.values(m.{path}.first), {text(part.rest, f'{path}.rest')})"

    groups = ", ".join(text(part, name) for name, part in zip(watch._fields, watch, strict=True))
    names = {"Pair": MonitorPair, "End": End, "Groups": MonitorGroups}
    return text_function(f"def judge(w, m): return Groups({groups})", names, "judge")
