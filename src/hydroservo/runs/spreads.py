"""How the metrics of many runs are spread."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydroservo.field import Field
from hydroservo.runs.results import metric_fields

if TYPE_CHECKING:
    import xarray as xr


class Spread(NamedTuple):
    """How a metric is spread over the runs that did not diverge, in SI units; nan where none has it."""

    p05: float
    median: float
    p95: float
    worst: float


def spreads_of(table: "xr.Dataset") -> dict[str, Spread]:
    """How each metric of many runs is spread, by its name; flags have no spread.

    Args:
        table: what ``simulate_batch`` returned.
    """
    kept, fields = ~table["diverged"].values, metric_fields(table)
    numbers = {name: field for name, field in fields.items() if table[name].dtype != bool}
    return {name: spread_of(field, table[name].values[kept]) for name, field in numbers.items()}


def spread_of(field: Field, values: np.ndarray) -> Spread:
    finite = values[np.isfinite(values)]
    if not finite.size:
        return Spread(*[float("nan")] * 4)
    worst = finite.min() if field.least_is_worst else finite.max()
    p05, median, p95 = map(float, np.quantile(finite, (0.05, 0.5, 0.95)))
    return Spread(p05, median, p95, float(worst))
