"""SciPy's solve_ivp, with laws in plain Python floats, which are faster one by one than NumPy's.

The plant alone: the fastest of four methods, each at the loosest tolerance that is accurate enough. The
closed loop: a call for each sample period, in which the command is held, at a tolerance that one Runge-Kutta
step of order 5 meets; that is how a sampled controller meets a continuous machine there. Slow, so only a part
of the job is run.
"""

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from benchmarks.jobs import Job, Result, end_state
from benchmarks.laws import (
    PLAIN,
    Machine,
    demand,
    law_of,
    machine_of,
    machine_rates,
    open_loop_rates,
    sample,
    start,
    valve,
    wave,
)
from benchmarks.peer import Prepared, at_tolerance, fastest, missing

__all__ = ["METHODS", "SciPy", "run_of"]

METHODS = ("RK45", "DOP853", "LSODA", "Radau")
MOST_STEPS, MOST_RUNS = 1_000, 2


class SciPy(NamedTuple):
    """solve_ivp."""

    name: str = "SciPy solve_ivp"

    def available(self) -> str | None:
        return missing("scipy")

    def fitted(self, job: Job) -> Job | None:
        if job.threads > 1 or job.on_axis:
            return None
        return job if job.plant_only else job.shortened(MOST_STEPS, MOST_RUNS)

    def prepare(self, job: Job) -> Prepared:
        if job.plant_only:
            return fastest(partial(tolerant, job, method) for method in METHODS)
        return Prepared(lambda: closed_loops(job), "RK45, one step a sample")


def tolerant(job: Job, method: str) -> Prepared:
    c = machine_of(job.loop, {})
    return at_tolerance(job, method, lambda rtol: plant_end(job, c, method, rtol))


def plant_end(job: Job, c: Machine, method: str, rtol: float) -> Result:
    from scipy.integrate import solve_ivp

    done = solve_ivp(
        lambda t, x: open_loop_rates(PLAIN, c, t, x.tolist()),
        (0.0, job.loop.simulation.duration),
        start(c)[0],
        method=method,
        rtol=rtol,
        atol=rtol * np.array([1e-2, 1e2, 1e-2]),
    )
    return end_state(done.y[:, -1])


def closed_loops(job: Job) -> Result:
    machines = [run_of(job, i) for i in range(job.runs)]
    return {"steady_rms_error": np.array([closed_loop(job, c) for c in machines])}


def run_of(job: Job, i: int) -> Machine:
    """The machine of one run, in plain floats."""
    c = machine_of(job.loop, job.varied)
    return Machine(*(float(np.broadcast_to(value, job.runs)[i]) for value in c))


def closed_loop(job: Job, c: Machine) -> float:
    from scipy.integrate import solve_ivp

    p, dt = law_of(job.loop), job.period
    x, s = start(c)
    squares = 0.0
    for k in range(job.steps):
        t = k * dt
        r = demand(PLAIN, c, t)
        if 2 * k >= job.steps:
            squares += (x[0] - r[0]) ** 2
        s = sample(PLAIN, p, x, r, s, dt)
        held = valve(PLAIN, c, s[0])

        def rates(since: float, y: Any, t: float = t, held: Any = held) -> Any:
            load = wave(PLAIN, c.load_amplitude, c.load_omega, t + since)
            return machine_rates(PLAIN, c, held, load, y.tolist())

        done = solve_ivp(rates, (0.0, dt), x, method="RK45", first_step=dt, rtol=1e-3, atol=1e-3)
        x = tuple(done.y[:, -1].tolist())
    return math.sqrt(squares / (job.steps // 2))
