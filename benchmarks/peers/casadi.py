"""CasADi: one sample as a Function over SX, folded over the samples and mapped over the runs.

The folded function is compiled from C that CasADi generates, where there is gcc. The plant alone: the faster
of a folded Runge-Kutta step and CVODES (through integrator) at the loosest tolerance that is accurate enough.
"""

import shutil
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from benchmarks.isa import gcc_flags
from benchmarks.jobs import Job, Result, end_state
from benchmarks.laws import Machine, Maths, closed_loop_step, law_of, machine_of, open_loop_rates, rk4, start
from benchmarks.peer import STEPS, Prepared, at_tolerance, cheapest, fastest, missing

__all__ = ["CasADi"]


class CasADi(NamedTuple):
    """Function, fold and map."""

    name: str = "CasADi"

    def available(self) -> str | None:
        return missing("casadi")

    def fitted(self, job: Job) -> Job | None:
        return None if job.on_axis else job

    def prepare(self, job: Job) -> Prepared:
        if job.plant_only:
            return fastest([partial(folded, job), partial(tolerant, job)])
        return closed_loops(job)


def maths() -> Maths:
    import casadi as ca

    return Maths(ca.sin, ca.cos, ca.tanh, ca.sqrt, ca.power, ca.fmax, ca.fmin, ca.sign, ca.fabs)


def compiled() -> dict[str, Any]:
    """Options of a Function that make it machine code."""
    if not shutil.which("gcc"):
        return {}
    flags = ["-O3", *gcc_flags()]
    return {"jit": True, "compiler": "shell", "jit_options": {"compiler": "gcc", "flags": flags}}


def closed_loops(job: Job) -> Prepared:
    import casadi as ca

    c, p, dt = machine_of(job.loop, job.varied), law_of(job.loop), job.period
    k, squares = ca.SX.sym("k"), ca.SX.sym("squares")
    x, s = (ca.vertsplit(ca.SX.sym(name, n)) for name, n in (("x", 3), ("s", 6)))
    own = ca.SX.sym("c", len(c))
    after, controller, error = closed_loop_step(
        maths(), Machine(*ca.vertsplit(own)), p, k * dt, tuple(x), tuple(s), dt
    )
    total = squares + ca.if_else(2 * k >= job.steps, error * error, 0.0)
    state = ca.vertcat(k, *x, *s, squares, own)
    step = ca.Function("step", [state], [ca.vertcat(k + 1.0, *after, *controller, total, own)])
    whole = step.fold(job.steps)
    first = whole.mx_in(0)
    run = ca.Function("run", [first], [whole(first)], compiled())
    many = run.map(job.runs, "thread", job.threads) if job.threads > 1 else run.map(job.runs, "serial")
    rows = np.column_stack([np.broadcast_to(value, job.runs) for value in c]).astype(np.float64)
    at_rest = np.zeros((job.runs, 11))
    at_rest[:, 3] = c.start_position
    given = np.hstack([at_rest, rows]).T

    def call() -> Result:
        return {"steady_rms_error": np.sqrt(np.asarray(many(given))[10] / (job.steps // 2))}

    return Prepared(call, "machine code from generated C" if compiled() else "interpreted")


def plant_rates(job: Job, x: Any, t: Any) -> Any:
    c = machine_of(job.loop, {})
    return open_loop_rates(maths(), c, t, x)


def folded(job: Job) -> Prepared:
    """A Runge-Kutta step for the whole time, in generated C."""
    functions: dict[int, Any] = {}

    def end(steps: int) -> Result:
        if steps not in functions:
            functions[steps] = folded_steps(job, steps)
        return end_state(
            np.asarray(functions[steps](np.array([0.0, *start(machine_of(job.loop, {}))[0]])))[1:, 0]
        )

    steps = cheapest(job.exact, STEPS, end)
    return Prepared(lambda: end(steps), f"RK4 in generated C, {steps:,} steps")


def folded_steps(job: Job, steps: int) -> Any:
    import casadi as ca

    h = job.loop.simulation.duration / steps
    k, *x = ca.vertsplit(ca.SX.sym("state", 4))
    after = rk4(lambda t, y: plant_rates(job, y, t), k * h, tuple(x), h)
    whole = ca.Function("step", [ca.vertcat(k, *x)], [ca.vertcat(k + 1.0, *after)]).fold(steps)
    first = whole.mx_in(0)
    return ca.Function("plant", [first], [whole(first)], compiled())


def tolerant(job: Job) -> Prepared:
    """CVODES."""
    functions: dict[float, Any] = {}

    def end(rtol: float) -> Result:
        if rtol not in functions:
            functions[rtol] = cvodes(job, rtol)
        return end_state(np.asarray(functions[rtol](x0=start(machine_of(job.loop, {}))[0])["xf"])[:, 0])

    return at_tolerance(job, "CVODES", end)


def cvodes(job: Job, rtol: float) -> Any:
    import casadi as ca

    x, t = ca.SX.sym("x", 3), ca.SX.sym("t")
    problem = {"x": x, "t": t, "ode": ca.vertcat(*plant_rates(job, tuple(ca.vertsplit(x)), t))}
    options = {"reltol": rtol, "abstol": 1e-2 * rtol, "max_num_steps": 10**6}
    return ca.integrator("plant", "cvodes", problem, 0.0, job.loop.simulation.duration, options)
