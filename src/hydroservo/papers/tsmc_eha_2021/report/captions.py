"""What stands below Figures 3 to 10: what each shows, and what is seen in it, computed from its runs."""

import math

import numpy as np

from hydroservo.figures import panels
from hydroservo.figures.panels import Window
from hydroservo.formatting import measured, number, quantity
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.papers.tsmc_eha_2021.claims import outcome
from hydroservo.papers.tsmc_eha_2021.conditions import CONTROLLERS
from hydroservo.papers.tsmc_eha_2021.machine import AMPLITUDE, DURATION, PERIOD
from hydroservo.papers.tsmc_eha_2021.report.names import NAMES, Trajectories

START = 0.03  # [s] how much of the start from rest is shown
JUMP = 0.5 * PERIOD  # [s] the square's first
TROUGH = 0.75 * PERIOD  # [s] the sine's first

WHOLE = panels.WHOLE._replace(stop=DURATION)
SHORT = {
    "sine": Window("start", 0.0, START, label="time [ms]", factor=1e3, dots=True),
    "square": Window(
        f"jump at {JUMP:g} s", JUMP - 0.01, JUMP + 0.06, JUMP, "time after the jump [ms]", 1e3, dots=True
    ),
}
CLOSE = {
    "sine": Window("trough, close by", TROUGH - 0.1, TROUGH + 0.1),
    "square": Window("after the jump, close by", JUMP + 0.1, JUMP + 0.5 * PERIOD - 0.1),
}
VELOCITIES = "Piston velocity with the three controllers"
ERRORS = "Velocity errors of the three controllers"
ESTIMATES = "Lumped disturbances (grey) and their estimates by the observer of TSMC (green)"
SURFACES = "Sliding surfaces and command of TSMC"
READ = "Dots are recorded samples. What panels of the whole run cut off is named above them."


FIRST = f"first {1e3 * START:g} ms"
AT_JUMP = f"jump at {JUMP:g} s"


def caption(shown: str, demand: str, *panels: str) -> str:
    size, period = f"{1e3 * AMPLITUDE:g} mm/s", f"{PERIOD:g} s"
    return ". ".join((f"{shown}, {demand} demand of {size} amplitude and {period} period", *panels, READ))


CAPTIONS = {
    3: caption(
        VELOCITIES,
        "sine",
        "(a) Whole run",
        f"(b) {FIRST.capitalize()}",
        f"(c) Trough at {TROUGH:g} s, on a range for PI, TSMC and demand",
    ),
    4: caption(
        ERRORS,
        "sine",
        f"(a), (b) Whole run and {FIRST}, on a range for all three",
        "(c), (d) The same on a range for PI and TSMC",
    ),
    5: caption(
        VELOCITIES,
        "square",
        "(a) Whole run",
        f"(b) {AT_JUMP.capitalize()}",
        "(c) The level after that jump, on a range for PI, TSMC and demand",
    ),
    6: caption(
        ERRORS,
        "square",
        f"(a), (b) Whole run and {AT_JUMP}, on a range for all three",
        "(c), (d) The same on a range for the settled errors of PI and TSMC",
    ),
    7: caption(
        ESTIMATES,
        "sine",
        "(a), (c) Whole run",
        "(b), (d) Estimate less true disturbance",
    ),
    8: caption(
        ESTIMATES,
        "square",
        "(a), (c) Whole run, on a range without the spikes at the jumps",
        f"(b), (d) {AT_JUMP.capitalize()}",
    ),
    9: caption(
        SURFACES,
        "sine",
        "(a), (c), (e) Whole run; ξ₂ on a range without its start",
        f"(b), (d), (f) {FIRST.capitalize()}",
    ),
    10: caption(
        SURFACES,
        "square",
        "(a), (c), (e) Whole run; ξ₁ on a range without the spikes at the jumps",
        f"(b), (d), (f) {AT_JUMP.capitalize()}",
    ),
}
"""By the figure's number."""


def seen_velocities(trajectories: Trajectories, demand: str) -> str:
    """How closely the three velocities follow a sine, or how fast and far they leave a square's jump."""
    if demand == "sine":
        peak = float(np.max(np.abs(trajectories["sine-pi"]["reference.value"].to_numpy())))
        worst = ranked(trajectories, demand, "steady_max_error")
        return f"Largest error in the second half, under a demand of {quantity(peak, 'm/s')} peak: {worst}."
    settling = ranked(trajectories, demand, "settling_time")
    overshoot = ranked(trajectories, demand, "overshoot")
    return (
        f"{METRIC_FIELDS['settling_time'].meaning.capitalize()} ({JUMP:g} s: not before the next jump): "
        f"{settling}. "
        f"Furthest beyond the demand in the direction of its last jump: {overshoot}."
    )


def seen_errors(trajectories: Trajectories, demand: str) -> str:
    """The three rms errors."""
    run = ranked(trajectories, demand, "rms_error")
    steady = ranked(trajectories, demand, "steady_rms_error")
    return f"Rms error over the whole run: {run}. In the second half: {steady}."


def seen_estimates(trajectories: Trajectories, demand: str) -> str:
    """What both estimates miss of what they estimate."""
    run = trajectories[f"{demand}-tsmc"]
    parts = []
    for i in (1, 2):
        miss, size = float(run[f"estimate_rms_error_{i}"]), float(run[f"disturbance_rms_{i}"])
        share = f"{number(100.0 * miss / size)} % of " if size > 0.0 else "against "
        parts.append(
            f"The estimate of d_L{i} misses by {measured(run, f'estimate_rms_error_{i}')} rms, {share}"
            f"the disturbance's {measured(run, f'disturbance_rms_{i}')} rms (second half); "
            f"the disturbance peaks at {measured(run, f'disturbance_max_{i}')}."
        )
    return " ".join(parts)


def seen_surfaces(trajectories: Trajectories, demand: str) -> str:
    """How close to zero the surfaces stay, and what command that takes."""
    run = trajectories[f"{demand}-tsmc"]
    settled = outcome(run, demand).settled
    return (
        f"Once settled |ξ₁| stays within {quantity(settled['xi1'], 'm/s')} and |ξ₂| within "
        f"{quantity(settled['xi2'], 'm/s^2')}. The command is {measured(run, 'control_rms')} rms, at most "
        f"{measured(run, 'control_max')}, and its changes add up to "
        f"{measured(run, 'control_total_variation')}."
    )


def ranked(trajectories: Trajectories, demand: str, metric: str) -> str:
    """The three controllers with one metric, the smallest first."""
    runs = {name: trajectories[f"{demand}-{name}"] for name in CONTROLLERS}

    def rank(name: str) -> float:
        value = float(runs[name][metric])
        return value if math.isfinite(value) else math.inf

    return ", ".join(f"{NAMES[name]} {measured(runs[name], metric)}" for name in sorted(runs, key=rank))
