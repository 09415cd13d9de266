"""Loops that may chatter: laws on valves, rates, gains and delays drawn at random."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from hydroservo import Loop, load_scenario
from hydroservo.audits import chatter, swing
from hydroservo.audits.audit import assumptions_in
from hydroservo.audits.facts import facts_of
from hydroservo.audits.monitors import SHARE

LOOK_FROM = 0.75  # [s]
LAST = 64  # samples, in which a command that never leaves its limit is lost
DURATION = 1.25  # [s], of which the last 0.5 s are looked at; the demand and the load have their peak at 1 s

TSMC = {
    "type": "TSMC",
    "linear_gain_1": 300.0,
    "linear_gain_2": 600.0,
    "power_gain_1": 10.0,
    "power_gain_2": 10.0,
    "exponent_1": "5/7",
    "exponent_2": "5/9",
    "derivative.type": "FilteredDerivative",
    "derivative.time_constant": 0.02,
}
SLIDING = {
    "observer.type": "TSMObserver",
    "observer.linear_gain_1": 50.0,
    "observer.linear_gain_2": 50.0,
    "observer.switching_gain_1": 30.0,
    "observer.switching_gain_2": 1e5,
    "observer.power_gain_1": 1.0,
    "observer.power_gain_2": 300.0,
    "observer.exponent": "5/7",
}
KALMAN = {
    "observer.type": "KalmanObserver",
    "observer.disturbance_1": 3.0,
    "observer.disturbance_2": 1e4,
    "observer.velocity_noise": 0.5e-3,
    "observer.hydraulic_force_noise": 5.0,
}
HIGH_GAIN = {
    "observer.type": "HighGainObserver",
    "observer.velocity_rate": 100.0,
    "observer.hydraulic_force_rate": 100.0,
}


def inverting(observer: Mapping[str, Any], error_dynamics: str, **numbers: Any) -> dict[str, Any]:
    """A law of error dynamics and an observer."""
    inner = {f"error_dynamics.{name.replace('__', '.')}": value for name, value in numbers.items()}
    derivative = {"derivative.type": "FilteredDerivative", "derivative.time_constant": 0.02}
    return {"type": "Inverting", "error_dynamics.type": error_dynamics, **inner, **observer, **derivative}


LAWS: dict[str, dict[str, Any]] = {
    "TSMC, explicit": {
        **TSMC,
        **SLIDING,
        "observer.realisation.type": "Explicit",
        "reaching.type": "ExplicitReaching",
    },
    "TSMC, boundary layer": {
        **TSMC,
        **SLIDING,
        "observer.realisation.type": "BoundaryLayer",
        "observer.realisation.velocity_thickness": 1e-3,
        "observer.realisation.force_thickness": 100.0,
        "reaching.type": "SmoothReaching",
    },
    "TSMC, implicit": {
        **TSMC,
        **SLIDING,
        "observer.realisation.type": "Implicit",
        "reaching.type": "ImplicitReaching",
    },
    "TSMC, explicit, Kalman": {**TSMC, **KALMAN, "reaching.type": "ExplicitReaching"},
    "terminal": inverting(
        KALMAN,
        "TerminalErrorDynamics",
        linear_gain_1=200.0,
        linear_gain_2=400.0,
        power_gain_1=50.0,
        power_gain_2=500.0,
        exponent_1="5/7",
        exponent_2="5/9",
    ),
    "super-twisting": inverting(KALMAN, "SuperTwisting", surface_gain=400.0, disturbance_rate=1e7),
    "naive super-twisting": inverting(
        HIGH_GAIN, "NaiveSuperTwisting", surface_gain=400.0, disturbance_rate=1e6
    ),
    "homogeneous, implicit": inverting(
        KALMAN, "HomogeneousErrorDynamics", error_gain=3e4, rate_gain=200.0, exponent=0.8
    ),
    "homogeneous, explicit": inverting(
        KALMAN,
        "HomogeneousErrorDynamics",
        error_gain=3e4,
        rate_gain=200.0,
        exponent=0.8,
        reaching__type="ExplicitReaching",
    ),
    "nonsingular, implicit": inverting(
        KALMAN,
        "NonsingularTerminalErrorDynamics",
        surface_gain=2e4,
        linear_gain=200.0,
        power_gain=10.0,
        surface_exponent="9/7",
        exponent="5/9",
    ),
    "nonsingular, explicit": inverting(
        KALMAN,
        "NonsingularTerminalErrorDynamics",
        surface_gain=2e4,
        linear_gain=200.0,
        power_gain=10.0,
        surface_exponent="9/7",
        exponent="5/9",
        reaching__type="ExplicitReaching",
    ),
    "RISE": inverting(
        KALMAN,
        "RISEErrorDynamics",
        surface_gain=400.0,
        feedback_gain=400.0,
        integral_rate=10.0,
        sign_gain=3e4,
    ),
    "linear": inverting(KALMAN, "LinearErrorDynamics", first_pole=300.0, second_pole=600.0),
    "PI": {"type": "PI", "proportional_gain": 3.2, "integral_gain": 600.0},
}
GAINS = (
    "linear_gain",
    "linear_gain_1",
    "linear_gain_2",
    "power_gain",
    "power_gain_1",
    "power_gain_2",
    "surface_gain",
    "disturbance_rate",
    "error_gain",
    "rate_gain",
    "feedback_gain",
    "sign_gain",
    "first_pole",
    "second_pole",
    "proportional_gain",
    "integral_gain",
)
PERIODS = (1e-3, 4e-4, 1e-4)  # [s]
LAGS = (2e-3, 5e-3, 10e-3)  # [s], as the law knows it
MISMATCHES = (0.6, 1.0, 1.6)  # the valve's lag by that
FACTORS = (0.3, 1.0, 3.0)  # of all gains of the law
SWITCHING = (0.1, 1.0, 10.0)  # of the observer's switching gains
DELAYS = (0.0, 1.0)  # sample periods
SCALES = (0.0, 1.0, 2.0)  # of the uncertainty


class Case(NamedTuple):
    """A loop of the grid."""

    law: str
    period: float
    lag: float
    mismatch: float
    factor: float
    switching: float
    delay: float
    scale: float


def cases(each: int, seed: int = 2) -> Iterator[Case]:
    """So many loops of each law, none twice, the same for the same seed."""
    for number, law in enumerate(LAWS):
        random = np.random.default_rng([seed, number])
        found: dict[Case, None] = {}
        sliding = "observer.switching_gain_1" in LAWS[law]
        while len(found) < each:
            drawn = [
                float(random.choice(values)) for values in (PERIODS, LAGS, MISMATCHES, FACTORS, SWITCHING)
            ]
            rest = [float(random.choice(values)) for values in (DELAYS, SCALES)]
            drawn[-1] = drawn[-1] if sliding else 1.0
            found[Case(law, *drawn, *rest)] = None
        yield from found


def loop_of(case: Case) -> Loop:
    """The loop of a case: the rig's, with exact sensors, on the sine, the law behind a valve inversion."""
    inner = {}
    for path, value in LAWS[case.law].items():
        name = path.rpartition(".")[2]
        own = path in GAINS or path.startswith("error_dynamics.")
        scaled = own and name in GAINS
        factor = case.factor if scaled else case.switching if name.startswith("switching_gain") else 1.0
        inner[path] = value * factor if isinstance(value, float) else value
    table = {"controller.type": "ValveInversion", "controller.time_constant": case.lag}
    table |= {f"controller.controller.{path}": value for path, value in inner.items()}
    if case.law == "PI":
        table = {f"controller.{path}": value for path, value in inner.items()}
    machine = {
        "valve.time_constant": case.lag * case.mismatch,
        "uncertainty.scale": case.scale,
        "hold.type": "DelayedHold",
        "hold.delay": case.delay * case.period,
        "simulation.period": case.period,
        "simulation.record_period": case.period,
        "simulation.duration": DURATION,
        "simulation.substeps": max(1, round(case.period / 1e-4)),
    }
    return load_scenario("rig/1khz-pi-sine", {**machine, **table})


class Judged(NamedTuple):
    """What became of a loop, and what was foretold of it.

    Attributes:
        case: the loop.
        lost: the run diverged, or ended with its command at one limit, where nothing swings any more.
        amplitude: of the command's swing [V].
        frequency: of that [Hz].
        chatters: whether that is more than what counts.
        foretold: the same by the forecast.
        foretold_amplitude: [V].
        foretold_frequency: [Hz].
        after_a_jolt: the swing that a jolt was to lead to [V].
        failed: the names of the assumptions that fail.
        untold: of those that cannot be told.
    """

    case: Case
    lost: bool
    amplitude: float
    frequency: float
    chatters: bool
    foretold: bool
    foretold_amplitude: float
    foretold_frequency: float
    after_a_jolt: float
    failed: tuple[str, ...]
    untold: tuple[str, ...]


def judged(case: Case) -> Judged:
    """A loop that is run, and its forecast and its assumptions, which know nothing of how it ended."""
    loop = loop_of(case)
    facts, data = facts_of(loop, record=("controller.u",))
    u = data["controller.u"].to_numpy()[round(LOOK_FROM / case.period) :]
    swung, forecast = swing(u, case.period), chatter(loop)
    limit = facts.limit
    stuck = max(u[-LAST:].min(), -u[-LAST:].max()) >= 0.999 * limit  # at one limit, and not between both
    lost = bool(data["diverged"]) or bool(stuck)
    every = [one for block in assumptions_in(facts.loop.controller, facts) for one in block.assumptions or ()]
    return Judged(
        case,
        lost,
        swung.amplitude,
        swung.frequency / (2.0 * np.pi),
        swung.amplitude > SHARE * limit,
        forecast.chatters,
        forecast.amplitude,
        forecast.frequency,
        forecast.after_a_jolt,
        tuple(one.name for one in every if one.holds is False),
        tuple(one.name for one in every if one.holds is None),
    )
