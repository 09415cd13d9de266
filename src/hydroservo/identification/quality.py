"""How well each log is met."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from hydroservo.identification.held_out import HeldOut, rms
from hydroservo.identification.misfit import misfit, residuals_by_signal
from hydroservo.identification.problem import Problem, simulated
from hydroservo.identification.result import LogFit, SignalFit
from hydroservo.identification.search import Solution
from hydroservo.identification.segments import Understood
from hydroservo.identification.signals import SIGNALS
from hydroservo.identification.spikes import TO_DEVIATION
from hydroservo.identification.uncertainty import Uncertainty
from hydroservo.identification.whiteness import autocorrelation, whiteness

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["log_fits"]


def log_fits(
    problem: Problem,
    best: Solution,
    sure: Uncertainty,
    taken: Sequence[Understood],
    apart: Mapping[tuple[int, str], HeldOut],
) -> list[LogFit]:
    """Each log as it was met by what was found."""
    every = residuals_by_signal(problem, misfit(problem, best.x, best.weights, slopes=False))
    found = []
    for log, one in enumerate(taken):
        names = list(dict.fromkeys(name for number, name in every if number == log))
        signals = {}
        for name in names:
            parts, weight = every[log, name], best.weights[log, name]
            values = np.concatenate(parts) / weight
            spread = problem.spread[log, name]
            signals[name] = SignalFit(
                rms=rms(values),
                noise=TO_DEVIATION * float(np.median(np.abs(values))),
                explained=1.0 - float(np.var(values)) / spread**2,
                whiteness=whiteness(parts),
                correlation=autocorrelation(parts, 1),
                held_out=apart[log, name].outside,
                held_in=apart[log, name].inside,
                offset=of_log(problem, best, sure, log, "offset", name),
                unit=SIGNALS[name].unit,
            )
        delay = of_log(problem, best, sure, log, "delay")
        found.append(LogFit(one, delay, signals, data_of(problem, best, log)))
    return found


def of_log(
    problem: Problem, best: Solution, sure: Uncertainty, log: int, kind: str, key: str = ""
) -> tuple[float, float]:
    """An unknown of a log and its standard deviation, in SI units; 0 if there is none."""
    for i, one in enumerate(problem.unknowns):
        if one.kind == kind and one.where == log and key in ("", one.key):
            return float(best.x[i] * one.scale), float(sure.deviations[i] * one.scale)
    return 0.0, 0.0


def data_of(problem: Problem, best: Solution, log: int) -> "xr.Dataset":
    """Measured and simulated signals of a log over its time."""
    import xarray as xr

    shown = simulated(problem, best.x, slopes=False)
    parts = []
    for one, values in zip(problem.experiments, shown, strict=True):
        if one.segment.log != log:
            continue
        own = {
            name: ("time", row, about(name))
            for name, row in (*one.segment.inputs.items(), *one.segment.measured.items())
        }
        own |= {f"{name}_simulated": ("time", row, about(name)) for name, row in values.values.items()}
        time = ("time", one.segment.time, {"units": "s", "long_name": "time"})
        parts.append(xr.Dataset(own, coords={"time": time}))
    return xr.concat(parts, "time") if len(parts) > 1 else parts[0]


def about(name: str) -> dict[str, str]:
    """Unit and meaning of a signal."""
    return {"units": SIGNALS[name].unit, "long_name": SIGNALS[name].meaning}
