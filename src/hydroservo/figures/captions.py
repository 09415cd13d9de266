"""What stands below Figures 3 to 10: what each shows, and what is seen in it, computed from its runs."""

import math

import numpy as np

from hydroservo.figures.names import NAMES, Trajectories
from hydroservo.figures.words import measured, number, quantity
from hydroservo.papers.tsmc_eha_2021.claims import outcome
from hydroservo.papers.tsmc_eha_2021.conditions import CONTROLLERS

__all__ = ["CAPTIONS", "seen_errors", "seen_estimates", "seen_surfaces", "seen_velocities"]

VELOCITIES = "Piston velocity with the three controllers"
ERRORS = "Velocity errors of the three controllers"
ESTIMATES = "Lumped disturbances (grey) and their estimates by the observer of TSMC (green)"
SURFACES = "Sliding surfaces and command of TSMC"
READ = "Dots are recorded samples. What panels of the whole run cut off is named above them."


def caption(shown: str, demand: str, *panels: str) -> str:
    return ". ".join((f"{shown}, {demand} demand of 30 mm/s amplitude and 4 s period", *panels, READ))


CAPTIONS = {
    3: caption(
        VELOCITIES,
        "sine",
        "(a) Whole run",
        "(b) First 30 ms",
        "(c) Trough at 3 s, on a range for PI, TSMC and demand",
    ),
    4: caption(
        ERRORS,
        "sine",
        "(a), (b) Whole run and first 30 ms, on a range for all three",
        "(c), (d) The same on a range for PI and TSMC",
    ),
    5: caption(
        VELOCITIES,
        "square",
        "(a) Whole run",
        "(b) Jump at 2 s",
        "(c) The level after that jump, on a range for PI, TSMC and demand",
    ),
    6: caption(
        ERRORS,
        "square",
        "(a), (b) Whole run and jump at 2 s, on a range for all three",
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
        "(b), (d) Jump at 2 s",
    ),
    9: caption(
        SURFACES,
        "sine",
        "(a), (c), (e) Whole run; ξ₂ on a range without its start",
        "(b), (d), (f) First 30 ms",
    ),
    10: caption(
        SURFACES,
        "square",
        "(a), (c), (e) Whole run; ξ₁ on a range without the spikes at the jumps",
        "(b), (d), (f) Jump at 2 s",
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
        f"Longest time from a jump until within 5 % of the demand's peak (2 s: not before the next jump): "
        f"{settling}. "
        f"Largest error in the direction of the last jump: {overshoot}."
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
