"""What a run left behind, before it is a Dataset."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from dataclasses import replace as replaced
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import declared_metrics, monitors_of, signals_of
from hydroservo.core.block import Block, leaves, state_field_at, value_at
from hydroservo.core.errors import LoopError, ParameterError
from hydroservo.core.field import Field
from hydroservo.runs.provenance import provenance

if TYPE_CHECKING:
    import xarray as xr

LARGEST_TRACE = 2**31  # bytes
MOST_SAMPLES = 2**51  # of a run: up to there each has a number and an instant of its own in doubles


class RunPlan(NamedTuple):
    """A run laid out: how many samples, which of them are recorded, and what of each."""

    samples: int
    stride: int
    rows: int
    paths: tuple[str, ...]
    fields: tuple[Field, ...]


@dataclass(frozen=True, eq=False)
class Trace(Mapping[str, Any]):
    """What a run left behind, read like the Dataset that :func:`run_dataset` makes of it with xarray."""

    asked: Loop  # what was to be run
    loop: Loop  # that, with all that was found for it
    plan: RunPlan  # what of it was recorded
    # paths of that which its user asked for; its keys are these, and the names of its metrics
    wanted: Sequence[str]
    out: np.ndarray  # what was recorded, shape (rows, paths)
    judgement: Sequence[float | bool]  # the values of its metrics
    attrs: dict[str, Any]  # what is to be said of it besides

    @cached_property
    def fields(self) -> dict[str, Field]:
        """The declaration of each metric by name."""
        return declared_metrics(monitors_of(self.loop), self.loop.controls)

    @cached_property
    def metrics(self) -> dict[str, float | bool]:
        """The metrics by name, in SI units."""
        return dict(zip(self.fields, self.judgement, strict=True))

    @cached_property
    def about(self) -> dict[str, Any]:
        """The attributes of its Dataset: where it comes from, and what is to be said of it."""
        return provenance(self.loop, self.asked) | self.attrs

    def __getitem__(self, name: str) -> Any:
        """The instants of the samples, at "time" [s], what was recorded at a path, or a metric."""
        if name == "time":
            return instants(self.plan.rows, self.plan.stride, self.loop.simulation.period)
        if name in self.plan.paths:
            return self.out[:, self.plan.paths.index(name)]
        return self.metrics[name]

    def __iter__(self) -> Iterator[str]:
        return iter((*self.wanted, *self.metrics))

    def __contains__(self, name: object) -> bool:
        return name in self.wanted or name in self.metrics

    def __len__(self) -> int:
        return len(self.wanted) + len(self.metrics)

    def assign_attrs(self, **attrs: Any) -> "Trace":
        return replaced(self, attrs=self.attrs | attrs)


def instants(count: int, stride: int, period: float) -> NDArray[np.float64]:
    """Multiples of a period as they are written: 9 times 1 ms is 0.009, where 9 * 0.001 is not."""
    written, numbers = Fraction(repr(float(period))), np.arange(count, dtype=np.float64)
    if max(count * stride * written.numerator, written.denominator) >= 2**53:  # not exact as floats
        return numbers * stride * period
    return numbers * (stride * written.numerator) / written.denominator


def run_dataset(trace: Trace) -> "xr.Dataset":
    """What a run left as a Dataset, with the trajectories that were asked for alone."""
    import xarray as xr

    fields = dict(zip(trace.plan.paths, trace.plan.fields, strict=True))
    signals = {path: ("time", trace[path], signal_attributes(fields[path])) for path in trace.wanted}
    scalars = {
        name: ((), value, metric_attributes(trace.fields[name])) for name, value in trace.metrics.items()
    }
    return xr.Dataset(
        signals | scalars,
        coords={"time": ("time", trace["time"], {"units": "s", "long_name": "time"})},
        attrs=trace.about,
    )


def signal_attributes(field: Field) -> dict[str, str]:
    """A declaration as the attributes of a variable."""
    return {"units": field.unit, "long_name": field.meaning}


def metric_attributes(field: Field) -> dict[str, str]:
    """The declaration of a metric as the attributes of a variable."""
    about = {**signal_attributes(field), "kind": "metric"}
    if field.smaller_is_better:
        about["better"] = "smaller"
    if field.least_is_worst:
        about["worst"] = "least"
    return about


def trace_size(loop: Loop, record: Sequence[str] | None = None) -> int:
    """Bytes that the recorded trajectory of a loop will take."""
    state = loop.init()
    return plan_size(plan_of(loop, state, record if record is not None else recordable_paths(loop, state)))


def plan_size(plan: RunPlan) -> int:
    """Bytes of the recorded numbers and their instants."""
    return 8 * plan.rows * (len(plan.paths) + 1)


def plan_of(loop: Loop, state: Block, record: Sequence[str]) -> RunPlan:
    """How a loop is run. What a kernel counts and addresses follows from these numbers alone."""
    simulation = loop.simulation
    ratio = simulation.duration / simulation.period
    if ratio >= MOST_SAMPLES:
        most = f"2^51 periods of {simulation.period:g} s, {MOST_SAMPLES * simulation.period:.3g} s"
        raise ParameterError("simulation.duration", simulation.duration, f"must be less than {most}")
    periods = whole_ratio(ratio)
    if periods is None or periods < 1:
        raise ParameterError(
            "simulation.period",
            simulation.period,
            f"must divide the duration of {simulation.duration:g} s into whole periods",
        )
    stride = whole_ratio(max(simulation.record_period / simulation.period, 1.0))
    if stride is None:
        raise ParameterError(
            "simulation.record_period",
            simulation.record_period,
            f"must be a whole number of sample periods of {simulation.period:g} s",
        )
    stride = min(stride, periods + 1)  # beyond the end, the first sample alone is recorded
    signals = signals_of(loop)
    fields = tuple(recorded_field(loop, state, signals, path) for path in record)
    plan = RunPlan(periods + 1, stride, periods // stride + 1, tuple(record), fields)
    size = plan_size(plan)
    if size > LARGEST_TRACE:
        raise LoopError(
            f"the recorded trajectory would take {size / 2**30:.1f} GiB; "
            f"raise simulation.record_period (now {simulation.record_period:g} s)"
        )
    return plan


def whole_ratio(ratio: float) -> int | None:
    """The whole number that a ratio of two times is meant to be, if it is one."""
    nearest = round(ratio) if math.isfinite(ratio) else -1
    return nearest if abs(ratio - nearest) <= 1e-9 * max(nearest, 1) else None


def recordable_paths(loop: Loop, state: Block) -> tuple[str, ...]:
    """All that can be recorded of a loop's state and of its monitors."""
    return (*(path for path, _ in leaves(state)), *signals_of(loop))


def recorded_field(loop: Loop, state: Block, signals: Mapping[str, Field], path: str) -> Field:
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
