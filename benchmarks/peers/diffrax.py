"""diffrax on the processor, in double precision.

The plant alone: diffeqsolve with the fastest of four solvers under its step size controller, each at the
loosest tolerance that is accurate enough. The closed loop: the controller in a scan over samples, and across
each one step of the cheapest solver that is accurate enough (Bosh3; diffrax has no classical Runge-Kutta), so
that no step straddles a change of the command. Many runs go through vmap.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from benchmarks.jobs import Job, Result, end_state
from benchmarks.laws import (
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
from benchmarks.peers.jax import batched, maths, over_samples

__all__ = ["Diffrax"]

SOLVERS = ("Tsit5", "Dopri5", "Dopri8", "Kvaerno5")


class Diffrax(NamedTuple):
    """diffeqsolve and its solvers' steps."""

    name: str = "diffrax"

    def available(self) -> str | None:
        return missing("diffrax")

    def fitted(self, job: Job) -> Job | None:
        return None if job.on_axis else job

    def prepare(self, job: Job) -> Prepared:
        if job.plant_only:
            return fastest(partial(tolerant, job, solver) for solver in SOLVERS)
        return closed_loops(job)


def tolerant(job: Job, solver: str) -> Prepared:
    return at_tolerance(job, solver, plant_end(job, solver))


def plant_end(job: Job, solver: str) -> Any:
    m = maths()
    import diffrax
    import jax
    import jax.numpy as jnp

    c, duration = machine_of(job.loop, {}), job.loop.simulation.duration

    def rates(t: Any, x: Any, _: Any) -> Any:
        return jnp.stack(open_loop_rates(m, c, t, x))

    @jax.jit
    def solve(rtol: Any) -> Any:
        control = diffrax.PIDController(rtol=rtol, atol=rtol * jnp.array([1e-2, 1e2, 1e-2]))
        done = diffrax.diffeqsolve(
            diffrax.ODETerm(rates),
            getattr(diffrax, solver)(),
            t0=0.0,
            t1=duration,
            dt0=1e-4,
            y0=jnp.array(start(c)[0]),
            stepsize_controller=control,
            max_steps=None,
        )
        return done.ys[-1]

    def end(rtol: float) -> Result:
        return end_state(np.asarray(solve(rtol)))

    return end


def closed_loops(job: Job) -> Prepared:
    m = maths()
    import diffrax
    import jax.numpy as jnp

    p, dt, steps = law_of(job.loop), job.period, job.steps
    solver = diffrax.Bosh3()

    def run(c: Machine) -> Any:
        def rates(t: Any, x: Any, held: Any) -> Any:
            return machine_rates(m, c, held, wave(m, c.load_amplitude, c.load_omega, t), x)

        term = diffrax.ODETerm(rates)

        def body(k: Any, carry: Any) -> Any:
            x, s, squares = carry
            t = k * dt
            r = demand(m, c, t)
            s = sample(m, p, x, r, s, dt)
            held = valve(m, c, s[0])
            memory = solver.init(term, t, t + dt, x, held)
            after, _, _, _, _ = solver.step(term, t, t + dt, x, held, memory, made_jump=False)
            error = x[0] - r[0]
            return after, s, squares + jnp.where(2 * k >= steps, error * error, 0.0)

        return jnp.sqrt(over_samples(job, c, body) / (steps // 2))

    return batched(job, run)._replace(how="Bosh3, one step a sample")
