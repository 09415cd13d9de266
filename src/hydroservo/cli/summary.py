"""The part of a run's result that fits on a screen."""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from hydroservo.formatting import quantity
from hydroservo.hooks import at_rest
from hydroservo.monitors.step_response import StepResponse, StepResponseValues
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.results import metrics_of
from hydroservo.runs.trace import Trace

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.cli.batch_summary import BatchSummary
    from hydroservo.loop import Loop

INSTANTS = 4001  # of a demand at which jumps are looked for
FEW = 101  # at which its size is


class RunSummary(NamedTuple):
    """A run's name, what identifies it, and its metrics in SI units; the fields of ``--json``."""

    scenario: str  # as the user named it
    hash: str
    version: str
    seed: int
    diverged_by: str  # the path of the number that was lost, the error, or nothing
    warnings: Sequence[str]
    metrics: Mapping[str, float | bool]


def run_summary(scenario: str, run: "Trace | xr.Dataset") -> RunSummary:
    """The summary of a run."""
    about, metrics = (run.about, run.metrics) if isinstance(run, Trace) else (run.attrs, metrics_of(run))
    name = (scenario, about["hash"], about["version"], int(about["seed"]))
    return RunSummary(*name, about["diverged_by"], warnings_of(run), metrics)


Summary = TypeVar("Summary", RunSummary, "BatchSummary")


def for_table(summary: Summary, loop: "Loop") -> Summary:
    """The summary of a run or a batch without what its demand gives no meaning.

    That is the settling time and the overshoot where nothing jumps.
    """
    meaningless = () if demand_jumps(loop) else StepResponseValues._fields
    metrics = {name: value for name, value in summary.metrics.items() if name not in meaningless}
    return summary._replace(metrics=metrics)


def demand_jumps(loop: "Loop") -> bool:
    """Whether the demand jumps, the start from rest included, as :class:`~.StepResponse` takes it.

    It looks at 4001 instants of the run. Fails for a demand that is away and back between two of them, which
    it does not see, and for one that turns as fast as that, which it takes for one that jumps.
    """
    monitor, end = StepResponse(), loop.simulation.duration
    state, system = monitor.init(), SimpleNamespace()
    machine = loop._replace(plant=at_rest(loop))
    signal = loop.controls.of(machine.seen(machine.init(), loop.load.force(0.0)), 0.0)
    step = end / (INSTANTS - 1)
    for t in np.linspace(0.0, end, INSTANTS).tolist():
        demand = loop.reference.at(t)
        follows = SimpleNamespace(value=demand.value if t else signal)
        state = monitor.step(state, system, SimpleNamespace(reference=demand, controlled=follows), t, step)
        if state.jump_sign != 0.0:
            return True
    return False


def astray(metrics: Mapping[str, float | bool], loop: "Loop") -> str:
    """That a loop does not follow: its rms error is more than the largest demand; else empty.

    Fails for a demand that is large between two of the 101 instants of the run at which it is looked at.
    """
    error = float(metrics.get("rms_error", 0.0))
    times = np.linspace(0.0, loop.simulation.duration, FEW).tolist()
    largest = max(abs(float(loop.reference.at(t).value)) for t in times)
    if metrics["diverged"] or not 0.0 < largest < error:
        return ""
    unit = loop.controls.declared().unit
    return (
        f"The loop does not follow: its rms error is {quantity(error, unit)}, and the largest demand "
        f"{quantity(largest, unit)}. hydroservo tune looks for better gains."
    )
