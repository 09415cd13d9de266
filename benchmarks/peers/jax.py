"""JAX on the processor, in double precision: the loop over samples as lax.scan, compiled whole.

One run is a scan over scalars, unrolled four times, which is the fastest; many are a scan under vmap, so over
one array for each number of the state. On one core the process is held to that core, so that XLA has one
thread. The metrics are left out but for the steady error.
"""

from typing import Any, NamedTuple

import numpy as np

from benchmarks.jobs import Job, end_state
from benchmarks.laws import Machine, Maths, closed_loop_step, law_of, machine_of, open_loop_rates, rk4, start
from benchmarks.peer import STEPS, Prepared, cheapest, missing

__all__ = ["Jax", "batched", "maths", "over_samples"]


class Jax(NamedTuple):
    """jit, scan and vmap."""

    name: str = "JAX"

    def available(self) -> str | None:
        return missing("jax")

    def fitted(self, job: Job) -> Job | None:
        return None if job.on_axis else job

    def prepare(self, job: Job) -> Prepared:
        return plant(job) if job.plant_only else closed_loops(job)


def maths() -> Maths:
    """JAX's functions, in double precision from now on."""
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)  # type: ignore[no-untyped-call]
    return Maths(jnp.sin, jnp.cos, jnp.tanh, jnp.sqrt, jnp.power, jnp.maximum, jnp.minimum, jnp.sign, jnp.abs)


def batched(job: Job, run: Any) -> Prepared:
    """A function of one machine over all machines of a job, compiled."""
    import jax

    c = machine_of(job.loop, job.varied)
    if not job.varied:
        one = jax.jit(run)
        return Prepared(lambda: {"steady_rms_error": np.atleast_1d(one(c))})
    axes = Machine(*(0 if isinstance(value, np.ndarray) else None for value in c))
    many = jax.jit(jax.vmap(run, in_axes=(axes,)))
    return Prepared(lambda: {"steady_rms_error": np.asarray(many(c))})


def closed_loops(job: Job) -> Prepared:
    m = maths()
    import jax.numpy as jnp

    p, dt, steps = law_of(job.loop), job.period, job.steps

    def run(c: Machine) -> Any:
        def body(k: Any, carry: Any) -> Any:
            x, s, squares = carry
            x, s, error = closed_loop_step(m, c, p, k * dt, x, s, dt)
            return x, s, squares + jnp.where(2 * k >= steps, error * error, 0.0)

        return jnp.sqrt(over_samples(job, c, body) / (steps // 2))

    return batched(job, run)


def over_samples(job: Job, c: Machine, body: Any) -> Any:
    """The sum that a body (sample number, carry) -> carry makes over all sample periods, from rest."""
    import jax
    import jax.numpy as jnp

    first = jax.tree.map(jnp.asarray, (*start(c), 0.0))
    numbers = jnp.arange(job.steps)
    unroll = 1 if job.varied else 4
    (_, _, total), _ = jax.lax.scan(lambda carry, k: (body(k, carry), None), first, numbers, unroll=unroll)
    return total


def plant(job: Job) -> Prepared:
    m = maths()
    import jax

    c, duration = machine_of(job.loop, {}), job.loop.simulation.duration

    @jax.jit
    def run(steps: Any) -> Any:
        h = duration / steps

        def body(k: Any, x: Any) -> Any:
            return rk4(lambda t, y: open_loop_rates(m, c, t, y), k * h, x, h)

        return jax.lax.fori_loop(0, steps, body, start(c)[0])

    steps = cheapest(job.exact, STEPS, lambda n: end_state(run(n)))
    return Prepared(lambda: end_state(run(steps)), f"RK4, {steps:,} steps")
