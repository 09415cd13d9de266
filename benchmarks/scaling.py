"""Cost against the number of runs and against the number of steps."""

from collections.abc import Callable, Sequence
from statistics import median

from benchmarks import peers
from benchmarks.jobs import Job, draw
from benchmarks.peer import Peer
from benchmarks.worker import Failed, Worker

__all__ = ["scaling"]

RUNS = (1, 3, 10, 32, 100, 1_000, 10_000, 100_000)
STEPS = (100, 1_000, 10_000, 100_000, 1_000_000)
COMPARED = ("hydroservo", "C scalar", "C SIMD", "numba by hand", "JAX")
WORK = 3_000_000  # samples of a measurement, shared by its runs
LEAST_STEPS = 1_000  # fewer, and the fixed cost of a run is all that shows
MOST_ROUNDS = 3

Points = list[tuple[int, float]]


def scaling(many: Job, rounds: int, say: Callable[[str], None]) -> dict[str, dict[str, Points]]:
    """By contender, seconds a sample by runs on one core, and seconds by steps of one run."""
    rounds = min(rounds, MOST_ROUNDS)
    many = many._replace(threads=1)
    batches = [batch(many, n, max(LEAST_STEPS, WORK // n)) for n in RUNS]
    singles = [batch(many, 1, n)._replace(varied={}) for n in STEPS]
    found: dict[str, dict[str, Points]] = {"runs": {}, "steps": {}}
    for peer in peers.ALL:
        if peer.name not in COMPARED or peer.available() is not None:
            continue
        say(f"cost against runs and steps: {peer.name}")
        by_runs = points(peer, batches, rounds)
        by_steps = points(peer, singles, rounds)
        found["runs"][peer.name] = [(job.runs, seconds / job.work) for job, seconds in by_runs]
        found["steps"][peer.name] = [(job.steps, seconds) for job, seconds in by_steps]
    return found


def batch(job: Job, runs: int, steps: int) -> Job:
    """A job of so many runs and steps."""
    simulation = job.loop.simulation._replace(duration=steps * job.period)
    return job._replace(loop=job.loop._replace(simulation=simulation), varied=draw(job.loop, runs))


def points(peer: Peer, jobs: Sequence[Job], rounds: int) -> list[tuple[Job, float]]:
    """The median seconds of each job, all in one process."""
    worker = Worker(peer.name, 1, "native")
    found = [
        (job, median(worker.seconds() for _ in range(rounds)))
        for job in jobs
        if peer.fitted(job) is job and not isinstance(worker.prepare(job), Failed)
    ]
    worker.close()
    return found
