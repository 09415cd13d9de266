"""What a run left behind, before it is a Dataset."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import declared_metrics, monitors_of
from hydroservo.core.field import Field
from hydroservo.runs.provenance import provenance

if TYPE_CHECKING:
    import xarray as xr


class Plan(NamedTuple):
    """A run laid out: how many samples, which of them are recorded, and what of each."""

    samples: int
    stride: int
    rows: int
    paths: tuple[str, ...]
    fields: tuple[Field, ...]


@dataclass(frozen=True, eq=False)
class Trace(Mapping[str, Any]):
    """What a run left behind; read like the Dataset that :func:`dataset` makes of it, for which xarray loads.

    Attributes:
        asked: what was to be run.
        loop: that, with all that was found for it.
        plan: what of it was recorded.
        wanted: paths of that which its user asked for; its keys are these, and the names of its metrics.
        out: what was recorded, shape (rows, paths).
        judgement: the values of its metrics.
        attrs: what is to be said of it besides.
    """

    asked: Loop
    loop: Loop
    plan: Plan
    wanted: Sequence[str]
    out: np.ndarray
    judgement: Sequence[float | bool]
    attrs: dict[str, Any]

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
        return replace(self, attrs=self.attrs | attrs)


def instants(count: int, stride: int, period: float) -> NDArray[np.float64]:
    """Multiples of a period as they are written: 9 times 1 ms is 0.009, where 9 * 0.001 is not.

    Args:
        count: how many, from 0 on.
        stride: periods from one to the next.
        period: of the samples [s].
    """
    written, numbers = Fraction(repr(float(period))), np.arange(count, dtype=np.float64)
    if max(count * stride * written.numerator, written.denominator) >= 2**53:  # not exact as floats
        return numbers * stride * period
    return numbers * (stride * written.numerator) / written.denominator


def dataset(trace: Trace) -> "xr.Dataset":
    """What a run left as a Dataset, with the trajectories that were asked for alone."""
    import xarray as xr

    fields = dict(zip(trace.plan.paths, trace.plan.fields, strict=True))
    signals = {path: ("time", trace[path], described(fields[path])) for path in trace.wanted}
    scalars = {name: ((), value, judged(trace.fields[name])) for name, value in trace.metrics.items()}
    return xr.Dataset(
        signals | scalars,
        coords={"time": ("time", trace["time"], {"units": "s", "long_name": "time"})},
        attrs=trace.about,
    )


def described(field: Field) -> dict[str, str]:
    """A declaration as the attributes of a variable."""
    return {"units": field.unit, "long_name": field.meaning}


def judged(field: Field) -> dict[str, str]:
    """The declaration of a metric as the attributes of a variable."""
    about = {**described(field), "kind": "metric"}
    if field.smaller_is_better:
        about["better"] = "smaller"
    if field.least_is_worst:
        about["worst"] = "least"
    return about
