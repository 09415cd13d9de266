"""python-control's input_output_response, with laws in plain Python floats.

The plant alone is a continuous nonlinear system, which python-control hands to SciPy. The closed loop is a
nonlinear system in discrete time that holds machine (one Runge-Kutta step a sample) and controller, because
python-control simulates no sampled controller around a continuous machine. Slow, so only a part of the job
is run.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from benchmarks.jobs import Job, Result, end_state
from benchmarks.laws import PLAIN, Machine, closed_loop_step, law_of, machine_of, open_loop_rates, start
from benchmarks.peer import Prepared, at_tolerance, fastest, missing
from benchmarks.peers.scipy import METHODS, run_of

__all__ = ["PythonControl"]

MOST_STEPS, MOST_RUNS = 4_000, 2


class PythonControl(NamedTuple):
    """input_output_response."""

    name: str = "python-control"

    def available(self) -> str | None:
        return missing("control")

    def fitted(self, job: Job) -> Job | None:
        if job.threads > 1 or job.on_axis:
            return None
        return job if job.plant_only else job.shortened(MOST_STEPS, MOST_RUNS)

    def prepare(self, job: Job) -> Prepared:
        if job.plant_only:
            return fastest(partial(tolerant, job, method) for method in METHODS)
        return Prepared(lambda: closed_loops(job), "RK4, discrete time")


def tolerant(job: Job, method: str) -> Prepared:
    return at_tolerance(job, method, lambda rtol: plant_end(job, method, rtol))


def plant_end(job: Job, method: str, rtol: float) -> Result:
    from control import input_output_response, nlsys  # type: ignore[import-untyped]

    c = machine_of(job.loop, {})

    def rates(t: float, x: Any, _u: Any, _params: Any) -> Any:
        return open_loop_rates(PLAIN, c, t, x.tolist())

    plant = nlsys(rates, states=3, inputs=0)
    done = input_output_response(
        plant,
        np.array([0.0, job.loop.simulation.duration]),
        initial_state=start(c)[0],
        solve_ivp_method=method,
        solve_ivp_kwargs={"rtol": rtol, "atol": rtol * np.array([1e-2, 1e2, 1e-2])},
    )
    return end_state(done.states[:, -1])


def closed_loops(job: Job) -> Result:
    errors = [closed_loop(job, run_of(job, i)) for i in range(job.runs)]
    return {"steady_rms_error": np.array(errors)}


def closed_loop(job: Job, c: Machine) -> float:
    from control import input_output_response, nlsys

    p, dt = law_of(job.loop), job.period
    x, s = start(c)

    def update(t: float, state: Any, _u: Any, _params: Any) -> tuple[float, ...]:
        numbers = state.tolist()
        after, controller, _ = closed_loop_step(PLAIN, c, p, t, numbers[:3], numbers[3:], dt)
        return (*after, *controller)

    loop = nlsys(update, states=len(x) + len(s), inputs=0, dt=dt)
    time = dt * np.arange(job.steps + 1)
    done = input_output_response(loop, time, initial_state=(*x, *s))
    error = done.states[0] - c.amplitude * np.sin(c.omega * time)
    return float(np.sqrt(np.mean(error[(job.steps + 1) // 2 : -1] ** 2)))
