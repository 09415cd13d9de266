"""numba by hand: the plain loop that a user writes, with scalars in local variables, compiled with fast-math.

The metrics are left out but for the steady error. Many runs go through prange, one thread on one core.
"""

from typing import NamedTuple

import numpy as np

from benchmarks.jobs import Job, Result, end_state
from benchmarks.laws import law_of, machine_of
from benchmarks.peer import STEPS, Prepared, cheapest, missing

__all__ = ["ByHand"]


class ByHand(NamedTuple):
    """@njit around loops."""

    name: str = "numba by hand"

    def available(self) -> str | None:
        return missing("numba")

    def fitted(self, job: Job) -> Job | None:
        return None if job.on_axis else job

    def prepare(self, job: Job) -> Prepared:
        from numba import set_num_threads

        set_num_threads(job.threads)
        return plant(job) if job.plant_only else closed_loop(job)


def closed_loop(job: Job) -> Prepared:
    from benchmarks.numba_loops import closed_loops

    c, p = machine_of(job.loop, job.varied), law_of(job.loop)
    rows = np.column_stack([np.broadcast_to(values, job.runs) for values in c]).astype(np.float64)
    law = tuple(float(value) for value in p)
    return Prepared(lambda: {"steady_rms_error": closed_loops(rows, law, job.steps, job.period)})


def plant(job: Job) -> Prepared:
    from benchmarks.numba_loops import plant_alone

    c = tuple(float(value) for value in machine_of(job.loop, {}))
    duration = job.loop.simulation.duration

    def end(steps: int) -> Result:
        return end_state(plant_alone(c, steps, duration / steps))

    steps = cheapest(job.exact, STEPS, end)
    return Prepared(lambda: end(steps), f"RK4, {steps:,} steps")
