"""The paper's claims as predicates over results.

Each claim is a ratio of what was measured to what it allows, the worst over what it speaks of; it holds
where the ratio is below 1. A run that diverged or has no number gives infinity: a result, not an error.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from hydroservo.controllers.tsmc import TSMC
from hydroservo.loads.constant import Constant
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.observers.tsm import TSMObserver
from hydroservo.references.square import Square

__all__ = ["AMPLITUDE", "CLAIMS", "CONVERGED", "SURFACE_GAIN", "Claim", "Outcome", "Results", "outcome"]

AMPLITUDE = Square().amplitude  # [m/s] of both demands
LOAD = Constant().amplitude  # [N] of both loads
DEMAND_RMS = {"sine": AMPLITUDE / math.sqrt(2.0), "square": AMPLITUDE}
SURFACE_GAIN = TSMC().linear_gain_1  # [1/s] mu_1, which carries a velocity error into xi2
TRACKING = 0.20  # tracking, generously: steady rms error below this part of the demand's rms
ESTIMATE = 0.10  # an estimate is consistent: error below this part of what it estimates
CONVERGED = 0.01  # converged: below this part of the signal's natural scale
LEAST_DISTURBANCE = (1.0, TSMObserver().switching_gain_2)  # [m/s^2], [N/s] a smaller one counts as this large
SETTLED_AFTER = 1.0  # [s] after the start and after each jump of the demand
HALF_PERIOD = 0.5 * Square().period  # [s] between jumps of the square demand

TRACKS = f"below {100 * TRACKING:g} % of the demand's rms, on both demands"
OF_DISTURBANCE = f"below {100 * ESTIMATE:g} % of the disturbance's rms"
FLOORS = f"(at least {LEAST_DISTURBANCE[0]:g} m/s^2 and {LEAST_DISTURBANCE[1]:g} N/s)"
SMALL_VELOCITY = f"{100 * CONVERGED:g} % of {1e3 * AMPLITUDE:g} mm/s"
SMALL_FORCE = f"{100 * CONVERGED:g} % of {LOAD:g} N"
SETTLED = f"within {SETTLED_AFTER:g} s of the start and of each jump"


class Outcome(NamedTuple):
    """What the claims need of one run: its metrics, and the largest sizes once settled.

    Settled samples lie a second or more after the start, and after each jump of the square demand.
    """

    metrics: Mapping[str, float]
    settled: Mapping[str, float]


Results = Mapping[tuple[str, str], Outcome]  # by demand and controller


class Claim(NamedTuple):
    """A claim of the paper, what it is taken to mean, and how far a condition is from breaking it."""

    name: str
    title: str
    test: str
    ratio: Callable[[Results], float]


def outcome(data: Any, demand: str) -> Outcome:
    """The outcome of a simulated run, from its Dataset and the name of its demand."""
    metrics = {name: float(data[name]) for name in METRIC_FIELDS}
    time = data["time"].to_numpy()
    since_jump = np.mod(time + 1e-9, HALF_PERIOD) if demand == "square" else time
    mask = since_jump >= SETTLED_AFTER

    def largest(values: Any) -> float:
        worst = np.max(np.abs(values[mask]))
        return float(worst) if np.isfinite(worst) else math.inf

    signals = {"error": data["plant.velocity"] - data["reference.value"]}
    if "controller.observer.d1" in data:
        signals |= {name: data[f"controller.{name}"] for name in ("xi1", "xi2")}
        signals |= {name: data[f"controller.observer.{name}"] for name in ("s1", "s2")}
        signals |= {f"miss{i}": data[f"controller.observer.d{i}"] - data[f"disturbance.d{i}"] for i in (1, 2)}
    return Outcome(metrics, {name: largest(values.to_numpy()) for name, values in signals.items()})


def over(measured: float, allowed: float) -> float:
    """measured/allowed; infinity where that is not a number."""
    if not math.isfinite(measured) or allowed <= 0.0:
        return math.inf
    return measured / allowed


def worst(ratios: Iterable[float]) -> float:
    return max(ratios)


def stable(run: Outcome) -> bool:
    return run.metrics["diverged"] == 0.0


def tracking(results: Results, controllers: tuple[str, ...]) -> float:
    return worst(
        over(run.metrics["steady_rms_error"], TRACKING * DEMAND_RMS[demand]) if stable(run) else math.inf
        for (demand, controller), run in results.items()
        if controller in controllers
    )


def against_rivals(results: Results, metric: str, demands: tuple[str, ...]) -> float:
    """TSMC's metric over its best rival's, worst over the demands; a rival that diverged is no rival."""

    def one(demand: str) -> float:
        own = results[demand, "tsmc"]
        rivals = [results[demand, name] for name in ("pi", "backstepping")]
        best = min((r.metrics[metric] for r in rivals if stable(r)), default=math.inf)
        if not stable(own) or not math.isfinite(own.metrics[metric]):
            return math.inf
        return 0.0 if best == math.inf else over(own.metrics[metric], best)

    return worst(one(demand) for demand in demands)


def disturbance(run: Outcome, i: int) -> float:
    size = run.metrics[f"disturbance_rms_{i}"]
    return max(size, LEAST_DISTURBANCE[i - 1]) if math.isfinite(size) else math.nan


def estimate(results: Results, i: int) -> float:
    runs = [results[demand, "tsmc"] for demand in ("sine", "square")]
    return worst(over(run.metrics[f"estimate_rms_error_{i}"], ESTIMATE * disturbance(run, i)) for run in runs)


def loop_stable(results: Results) -> float:
    runs = [results[demand, "tsmc"] for demand in ("sine", "square")]
    return worst(over(run.settled["error"], AMPLITUDE) if stable(run) else math.inf for run in runs)


def settled(results: Results, scales: Mapping[str, float]) -> float:
    runs = [results[demand, "tsmc"] for demand in ("sine", "square")]
    return worst(
        over(run.settled[name], CONVERGED * scale) if stable(run) else math.inf
        for run in runs
        for name, scale in scales.items()
    )


def estimates_settled(results: Results) -> float:
    runs = [results[demand, "tsmc"] for demand in ("sine", "square")]
    return worst(
        over(run.settled[f"miss{i}"], ESTIMATE * disturbance(run, i)) for run in runs for i in (1, 2)
    )


CLAIMS = (
    Claim(
        "1",
        "All three controllers track both demands",
        f"steady rms error of each {TRACKS}",
        lambda r: tracking(r, ("pi", "backstepping", "tsmc")),
    ),
    Claim(
        "1 (TSMC)",
        "TSMC tracks both demands",
        f"steady rms error of TSMC {TRACKS}",
        lambda r: tracking(r, ("tsmc",)),
    ),
    Claim(
        "2 (rms)",
        "TSMC tracks better: rms error",
        "rms error over the whole run below that of the better rival, on both demands",
        lambda r: against_rivals(r, "rms_error", ("sine", "square")),
    ),
    Claim(
        "2 (sine)",
        "TSMC tracks better on the sine: rms error",
        "rms error over the whole run below that of the better rival, on the sine",
        lambda r: against_rivals(r, "rms_error", ("sine",)),
    ),
    Claim(
        "2 (square)",
        "TSMC tracks better on the square: rms error",
        "rms error over the whole run below that of the better rival, on the square",
        lambda r: against_rivals(r, "rms_error", ("square",)),
    ),
    Claim(
        "2 (overshoot)",
        "TSMC tracks better: overshoot on the square",
        "overshoot below that of the better rival, on the square",
        lambda r: against_rivals(r, "overshoot", ("square",)),
    ),
    Claim(
        "2 (activity)",
        "TSMC asks less of the valve",
        "total variation of the command below that of the calmer rival, on both demands",
        lambda r: against_rivals(r, "control_total_variation", ("sine", "square")),
    ),
    Claim(
        "3 (d1)",
        "The estimate of d_L1 is consistent with the load",
        f"rms error of the estimate {OF_DISTURBANCE} {FLOORS}, second half, both demands",
        lambda r: estimate(r, 1),
    ),
    Claim(
        "3 (d2)",
        "The estimate of d_L2 is consistent with the model functions",
        f"rms error of the estimate {OF_DISTURBANCE} {FLOORS}, second half, both demands",
        lambda r: estimate(r, 2),
    ),
    Claim(
        "4 (loop)",
        "The loop with TSMC is stable",
        f"no divergence, and {SETTLED} an error below the demand's amplitude, both demands",
        loop_stable,
    ),
    Claim(
        "4 (observer)",
        "The observer's surfaces converge",
        f"{SETTLED} |s1| below {SMALL_VELOCITY} and |s2| below {SMALL_FORCE}, both demands",
        lambda r: settled(r, {"s1": AMPLITUDE, "s2": LOAD}),
    ),
    Claim(
        "4 (surfaces)",
        "The controller's surfaces converge",
        f"{SETTLED} |xi1| below {SMALL_VELOCITY} and |xi2| below mu_1 times that, both demands",
        lambda r: settled(r, {"xi1": AMPLITUDE, "xi2": SURFACE_GAIN * AMPLITUDE}),
    ),
    Claim(
        "5 (state)",
        "The velocity error converges in finite time",
        f"{SETTLED} below {SMALL_VELOCITY}, and it stays there, both demands",
        lambda r: settled(r, {"error": AMPLITUDE}),
    ),
    Claim(
        "5 (observer)",
        "The estimation errors converge in finite time",
        f"{SETTLED} {OF_DISTURBANCE} {FLOORS}, and they stay there, both demands",
        estimates_settled,
    ),
)
