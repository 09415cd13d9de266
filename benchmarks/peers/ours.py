"""hydroservo, through its public functions, with all that a user's call does besides the loop.

No trajectory is asked for, as the peers keep none; the usual metrics are computed. For the plant alone the
valve is a user's block that follows a smooth command, no metric is asked for, and the controller, to which it
does not listen, runs a few times: the steps that the accuracy asks for are substeps.
"""

from typing import NamedTuple

import numpy as np

from benchmarks.jobs import Job, Result, end_state
from benchmarks.peer import STEPS, Prepared, cheapest
from hydroservo import simulate, simulate_batch
from hydroservo.engine.cuda_driver import has_device

__all__ = ["Ours", "Strict"]

STATES = ("plant.velocity", "plant.hydraulic_force", "plant.position")
PERIODS = 10  # of the plant alone; the steps to try are multiples of it


class Ours(NamedTuple):
    """As it comes: multiplications and additions may be fused."""

    name: str = "hydroservo"
    strict: bool = False
    cuda: bool = False

    def available(self) -> str | None:
        return None if not self.cuda or has_device() else "there is no CUDA device"

    def fitted(self, job: Job) -> Job | None:
        return job

    def prepare(self, job: Job) -> Prepared:
        if job.plant_only:
            return self.plant(job)
        return Prepared(lambda: self.batch(job) if job.varied else self.single(job))

    def single(self, job: Job) -> Result:
        data = simulate(job.loop, record=(), strict=self.strict)
        return {
            str(name): np.atleast_1d(values.to_numpy().astype(float))
            for name, values in data.data_vars.items()
        }

    def batch(self, job: Job) -> Result:
        data = simulate_batch(job.loop, job.varied, threads=job.threads, strict=self.strict, cuda=self.cuda)
        return {
            str(name): values.to_numpy().astype(float)
            for name, values in data.data_vars.items()
            if name not in job.varied and values.dtype.kind in "bf"
        }

    def plant(self, job: Job) -> Prepared:
        steps = cheapest(job.exact, STEPS, lambda n: self.end(job, n))
        return Prepared(lambda: self.end(job, steps), f"RK4, {steps:,} steps")

    def end(self, job: Job, steps: int) -> Result:
        duration = job.loop.simulation.duration
        simulation = job.loop.simulation._replace(
            period=duration / PERIODS, substeps=steps // PERIODS, record_period=duration
        )
        loop = job.loop._replace(simulation=simulation)
        data = simulate(loop, record=STATES, metrics=(), strict=self.strict)
        return end_state([data[name].to_numpy()[-1] for name in STATES])


class AllCores(Ours):
    """The first of very many runs, on the processor."""

    def __new__(cls) -> "AllCores":
        return super().__new__(cls, "hydroservo, on all cores")

    def fitted(self, job: Job) -> Job | None:
        return job.shortened(job.steps, 10_000)


class Strict(Ours):
    """Equal to the interpreted loop, bit for bit."""

    def __new__(cls) -> "Strict":
        return super().__new__(cls, "hydroservo strict", True)
