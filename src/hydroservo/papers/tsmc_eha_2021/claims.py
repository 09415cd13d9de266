"""The paper's claims as predicates over results, and the conditions under which they are judged.

Each claim compares what was measured with what it allows, at the worst of what it speaks of; it holds where
their ratio is below 1. A run without that number gives infinity, as does one that diverged where the loop is
spoken of; a limit cycle is no divergence and is judged by its numbers. Estimates are judged by their errors
alone.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from hydroservo.papers.tsmc_eha_2021.machine import AMPLITUDE, LOAD, OBSERVER, PERIOD, TERMINAL, VALVE_LAG
from hydroservo.runs.results import metrics_of

DEMANDS = ("sine", "square")
CONTROLLERS = ("pi", "backstepping", "tsmc")
READINGS = ("corrected", "as printed")
SCALES = (-1, 0, 1)
REALISATIONS = {"explicit": "Explicit", "boundary layer": "BoundaryLayer", "implicit": "Implicit"}
VALVES: dict[str, dict[str, object]] = {
    "static": {"valve.type": "StaticValve"},
    "10 ms lag": {"valve.type": "FirstOrderValve", "valve.time_constant": VALVE_LAG},
}
PERIODS = {"10 us": 1e-5, "100 us": 1e-4, "1 ms": 1e-3}
STEP = 1e-5  # [s] the machine is integrated with this step whatever the sample period
DEMAND_RMS = {"sine": AMPLITUDE / math.sqrt(2.0), "square": AMPLITUDE}
SURFACE_GAIN = TERMINAL.linear_gain_1  # [1/s] mu_1, which carries a velocity error into xi2
TRACKING = 0.20  # tracking, generously: steady rms error below this part of the demand's rms
ESTIMATE = 0.10  # an estimate is consistent: error below this part of what it estimates
CONVERGED = 0.01  # converged: below this part of the signal's natural scale
LEAST_DISTURBANCE = (1.0, OBSERVER.switching_gain_2)  # [m/s^2], [N/s] a smaller one counts as this large
SETTLED_AFTER = 1.0  # [s] after the start and after each jump of the demand
HALF_PERIOD = 0.5 * PERIOD  # [s] between jumps of the square demand

TRACKS = f"below {100 * TRACKING:g} % of the demand's rms, on both demands"
OF_DISTURBANCE = f"below {100 * ESTIMATE:g} % of the disturbance's rms"
FLOORS = f"(at least {LEAST_DISTURBANCE[0]:g} m/s^2 and {LEAST_DISTURBANCE[1]:g} N/s)"
SMALL_VELOCITY = f"{100 * CONVERGED:g} % of {1e3 * AMPLITUDE:g} mm/s"
SMALL_FORCE = f"{100 * CONVERGED:g} % of {LOAD:g} N"
SETTLED = f"within {SETTLED_AFTER:g} s of the start and of each jump"


class Condition(NamedTuple):
    """One way to read, perturb, realise and sample the study."""

    reading: str
    delta: int  # the six uncertain parameters are at nominal + delta Delta
    realisation: str
    valve: str
    period: str


REPRODUCED = Condition("corrected", 1, "boundary layer", "static", "10 us")  # as reproduced
LITERAL = Condition("as printed", 1, "explicit", "static", "10 us")  # to the letter


class PaperRun(NamedTuple):
    """One closed loop; ``realisation`` is "" for laws without an observer."""

    demand: str
    controller: str
    reading: str
    delta: int
    realisation: str
    valve: str
    period: str

    def scenario(self) -> str:
        """The built-in scenario that this run varies."""
        return f"paper/{self.demand}-{self.controller}"

    def changes(self) -> dict[str, Any]:
        """What this run changes in its scenario, as ``--set`` would; its reading is no part of that."""
        period = PERIODS[self.period]
        changes: dict[str, Any] = {
            "uncertainty.scale": float(self.delta),
            "simulation.period": period,
            "simulation.substeps": round(period / STEP),
        } | VALVES[self.valve]
        if self.realisation:
            changes["controller.observer.realisation.type"] = REALISATIONS[self.realisation]
        return changes


def all_conditions() -> list[Condition]:
    """All conditions: readings x signs of Delta x realisations x valves x sample periods."""
    return [Condition(*one) for one in product(READINGS, SCALES, REALISATIONS, VALVES, PERIODS)]


def condition_runs(condition: Condition) -> dict[tuple[str, str], PaperRun]:
    """The six runs of a condition by demand and controller."""
    reading, delta, realisation, valve, period = condition
    return {
        (demand, controller): PaperRun(
            demand, controller, reading, delta, realisation if controller == "tsmc" else "", valve, period
        )
        for demand, controller in product(DEMANDS, CONTROLLERS)
    }


def all_runs() -> list[PaperRun]:
    """Every run that some condition needs, once, the longest first."""
    runs = dict.fromkeys(run for condition in all_conditions() for run in condition_runs(condition).values())
    return sorted(runs, key=lambda run: PERIODS[run.period])


class RunOutcome(NamedTuple):
    """What the claims need of one run: its metrics, and the largest sizes once settled.

    Settled samples lie a second or more after the start, and after each jump of the square demand.
    """

    metrics: Mapping[str, float]
    settled: Mapping[str, float]


Results = Mapping[tuple[str, str], RunOutcome]  # by demand and controller


class Judgement(NamedTuple):
    """What decides a claim: a number of one run, and the number that it must stay below."""

    demand: str  # of the run
    controller: str  # of the run
    name: str  # which of the outcome's metrics or settled sizes it is
    measured: float  # its value in SI units; infinite where the run diverged
    allowed: float  # the limit in the same unit; infinite where a rival is to be beaten and none is left
    rival: str = ""  # the controller whose number the limit is; "" where it is the claim's own

    @property
    def ratio(self) -> float:
        """measured/allowed; infinity where that is not a number."""
        if not math.isfinite(self.measured) or not self.allowed > 0.0:
            return math.inf
        return self.measured / self.allowed


class Claim(NamedTuple):
    """A claim of the paper, what it is taken to mean, and what decides it under one condition."""

    name: str
    title: str
    test: str
    judge: Callable[[Results], Judgement]


def run_outcome(data: Any, demand: str) -> RunOutcome:
    """The outcome of a simulated run, from its Dataset and the name of its demand."""
    metrics = {name: float(value) for name, value in metrics_of(data).items()}
    time = data["time"].to_numpy()
    since_jump = np.mod(time + 1e-9, HALF_PERIOD) if demand == "square" else time
    mask = since_jump >= SETTLED_AFTER

    def largest(values: Any) -> float:
        worst = np.max(np.abs(values[mask]))
        return float(worst) if np.isfinite(worst) else math.inf

    signals = {"error": data["reference.value"] - data["controlled.value"]}
    if "controller.xi1" in data:
        signals |= {name: data[f"controller.{name}"] for name in ("xi1", "xi2")}
        signals |= {name: data[f"controller.observer.{name}"] for name in ("s1", "s2")}
        signals |= {f"miss{i}": data[f"controller.observer.d{i}"] - data[f"disturbance.d{i}"] for i in (1, 2)}
    return RunOutcome(metrics, {name: largest(values.to_numpy()) for name, values in signals.items()})


def worst_judgement(judgements: Iterable[Judgement]) -> Judgement:
    return max(judgements, key=lambda judgement: judgement.ratio)


def is_stable(run: RunOutcome) -> bool:
    return run.metrics["diverged"] == 0.0


def run_metric(run: RunOutcome, name: str) -> float:
    """A metric of a run; infinite where the run diverged."""
    return run.metrics[name] if is_stable(run) else math.inf


def tracking_judgement(results: Results, controllers: tuple[str, ...]) -> Judgement:
    name = "steady_rms_error"
    return worst_judgement(
        Judgement(demand, controller, name, run_metric(run, name), TRACKING * DEMAND_RMS[demand])
        for (demand, controller), run in results.items()
        if controller in controllers
    )


def rival_judgement(results: Results, name: str, demands: tuple[str, ...]) -> Judgement:
    """TSMC's metric against its best rival's, worst over the demands; a rival that diverged is no rival."""

    def against_best(demand: str) -> Judgement:
        rivals = {rival: run_metric(results[demand, rival], name) for rival in ("pi", "backstepping")}
        best = min(rivals, key=lambda rival: rivals[rival])
        return Judgement(demand, "tsmc", name, run_metric(results[demand, "tsmc"], name), rivals[best], best)

    return worst_judgement(against_best(demand) for demand in demands)


def disturbance(run: RunOutcome, i: int) -> float:
    size = run.metrics[f"disturbance_rms_{i}"]
    return max(size, LEAST_DISTURBANCE[i - 1]) if math.isfinite(size) else math.nan


def estimate_judgement(results: Results, i: int) -> Judgement:
    name = f"estimate_rms_error_{i}"
    return worst_judgement(
        Judgement(demand, "tsmc", name, run.metrics[name], ESTIMATE * disturbance(run, i))
        for demand, run in runs_of_tsmc(results)
    )


def convergence_judgement(results: Results, limits: Mapping[str, float]) -> Judgement:
    """The settled sizes named, each against its limit."""
    return worst_judgement(
        Judgement(demand, "tsmc", name, run.settled[name] if is_stable(run) else math.inf, limit)
        for demand, run in runs_of_tsmc(results)
        for name, limit in limits.items()
    )


def estimates_judgement(results: Results) -> Judgement:
    return worst_judgement(
        Judgement(demand, "tsmc", f"miss{i}", run.settled[f"miss{i}"], ESTIMATE * disturbance(run, i))
        for demand, run in runs_of_tsmc(results)
        for i in (1, 2)
    )


def runs_of_tsmc(results: Results) -> list[tuple[str, RunOutcome]]:
    """TSMC's runs by demand."""
    return [(demand, results[demand, "tsmc"]) for demand in ("sine", "square")]


CLAIMS = (
    Claim(
        "1",
        "All three controllers track both demands",
        f"steady rms error of each {TRACKS}",
        lambda r: tracking_judgement(r, ("pi", "backstepping", "tsmc")),
    ),
    Claim(
        "1 (TSMC)",
        "TSMC tracks both demands",
        f"steady rms error of TSMC {TRACKS}",
        lambda r: tracking_judgement(r, ("tsmc",)),
    ),
    Claim(
        "2 (rms)",
        "TSMC tracks better: rms error",
        "rms error over the whole run below that of the better rival, on both demands",
        lambda r: rival_judgement(r, "rms_error", ("sine", "square")),
    ),
    Claim(
        "2 (sine)",
        "TSMC tracks better on the sine: rms error",
        "rms error over the whole run below that of the better rival, on the sine",
        lambda r: rival_judgement(r, "rms_error", ("sine",)),
    ),
    Claim(
        "2 (square)",
        "TSMC tracks better on the square: rms error",
        "rms error over the whole run below that of the better rival, on the square",
        lambda r: rival_judgement(r, "rms_error", ("square",)),
    ),
    Claim(
        "2 (overshoot)",
        "TSMC tracks better: overshoot on the square",
        "overshoot below that of the better rival, on the square",
        lambda r: rival_judgement(r, "overshoot", ("square",)),
    ),
    Claim(
        "2 (activity)",
        "TSMC asks less of the valve",
        "total variation of the command below that of the calmer rival, on both demands",
        lambda r: rival_judgement(r, "control_total_variation", ("sine", "square")),
    ),
    Claim(
        "3 (d1)",
        "The estimate of d_L1 is consistent with the load",
        f"rms error of the estimate {OF_DISTURBANCE} {FLOORS}, second half, both demands",
        lambda r: estimate_judgement(r, 1),
    ),
    Claim(
        "3 (d2)",
        "The estimate of d_L2 is consistent with the model functions",
        f"rms error of the estimate {OF_DISTURBANCE} {FLOORS}, second half, both demands",
        lambda r: estimate_judgement(r, 2),
    ),
    Claim(
        "4 (loop)",
        "The loop with TSMC is stable",
        f"no divergence, and {SETTLED} an error below the demand's amplitude, both demands",
        lambda r: convergence_judgement(r, {"error": AMPLITUDE}),
    ),
    Claim(
        "4 (observer)",
        "The observer's surfaces converge",
        f"{SETTLED} |s1| below {SMALL_VELOCITY} and |s2| below {SMALL_FORCE}, both demands",
        lambda r: convergence_judgement(r, {"s1": CONVERGED * AMPLITUDE, "s2": CONVERGED * LOAD}),
    ),
    Claim(
        "4 (surfaces)",
        "The controller's surfaces converge",
        f"{SETTLED} |xi1| below {SMALL_VELOCITY} and |xi2| below mu_1 times that, both demands",
        lambda r: convergence_judgement(
            r, {"xi1": CONVERGED * AMPLITUDE, "xi2": CONVERGED * (SURFACE_GAIN * AMPLITUDE)}
        ),
    ),
    Claim(
        "5 (state)",
        "The velocity error converges in finite time",
        f"{SETTLED} below {SMALL_VELOCITY}, and it stays there, both demands",
        lambda r: convergence_judgement(r, {"error": CONVERGED * AMPLITUDE}),
    ),
    Claim(
        "5 (observer)",
        "The estimation errors converge in finite time",
        f"{SETTLED} {OF_DISTURBANCE} {FLOORS}, and they stay there, both demands",
        estimates_judgement,
    ),
)
