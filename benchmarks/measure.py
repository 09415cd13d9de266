"""Rounds in which each contender runs once, in another order each time."""

from collections.abc import Callable, Sequence
from statistics import median
from typing import NamedTuple

import numpy as np

from benchmarks import peers
from benchmarks.jobs import Job, Result
from benchmarks.peer import Peer, difference
from benchmarks.worker import Failed, First, Worker

__all__ = ["Entry", "Missing", "measured"]

Say = Callable[[str], None]


class Entry(NamedTuple):
    """What one contender did."""

    name: str
    how: str
    seconds: float  # median over the rounds, for the whole job
    rounds: list[float]  # as measured
    steps: int  # of those that were run, per run
    runs: int
    share: float  # of the whole job that was run
    first: float  # [s] to the first result, compilation included
    memory: int | None  # [byte] at the most
    difference: float  # relative, to the exact answer or else to hydroservo's


class Missing(NamedTuple):
    """A contender that is left out, and why."""

    name: str
    reason: str


class Contender(NamedTuple):
    """A peer at work."""

    peer: Peer
    job: Job
    worker: Worker
    first: First


def measured(
    job: Job,
    chosen: Sequence[Peer],
    rounds: int,
    instructions: str,
    say: Say,
    yardstick: Peer = peers.YARDSTICK,
) -> tuple[list[Entry], list[Missing]]:
    """Each peer's figures for a job, in the order given, and those that are left out."""
    ready: list[Contender] = []
    missing: list[Missing] = []
    try:
        for peer in chosen:
            part = peer.fitted(job)
            if part is None:
                continue
            say(f"{job.name}: {peer.name} gets ready")
            one = contender(peer, part, instructions, yardstick)
            if isinstance(one, Missing):
                missing.append(one)
            else:
                ready.append(one)
        times = interleaved(ready, rounds, lambda i: say(f"{job.name}: round {i + 1} of {rounds}"))
        return [entry(job, one, times[one.peer.name], instructions, yardstick) for one in ready], missing
    finally:
        for one in ready:
            one.worker.close()


def contender(peer: Peer, job: Job, instructions: str, yardstick: Peer) -> Contender | Missing:
    reason = peer.available()
    if reason is not None:
        return Missing(peer.name, reason)
    worker = Worker(peer.name, job.threads, instructions)
    first = worker.prepare(job)
    if isinstance(first, Failed):
        worker.close()
        return Missing(peer.name, first.reason)
    if peer is yardstick:
        ANSWERS[job.steps, job.runs] = first.result
    return Contender(peer, job, worker, first)


def interleaved(
    contenders: Sequence[Contender], rounds: int, say: Callable[[int], None]
) -> dict[str, list[float]]:
    """Seconds of each contender in each round."""
    times: dict[str, list[float]] = {one.peer.name: [] for one in contenders}
    order = np.random.default_rng(0)
    for i in range(rounds):
        say(i)
        for at in order.permutation(len(contenders)):
            one = contenders[at]
            times[one.peer.name].append(one.worker.seconds())
    return times


def entry(job: Job, one: Contender, times: list[float], instructions: str, yardstick: Peer) -> Entry:
    share = one.job.work / job.work
    return Entry(
        name=one.peer.name,
        how=one.first.how,
        seconds=median(times) / share,
        rounds=times,
        steps=one.job.steps,
        runs=one.job.runs,
        share=share,
        first=one.first.seconds,
        memory=one.worker.memory(),
        difference=difference(one.first.result, one.job.exact or answer(one.job, instructions, yardstick)),
    )


ANSWERS: dict[tuple[int, int], Result] = {}  # by steps and runs; the threads do not matter


def answer(job: Job, instructions: str, yardstick: Peer) -> Result:
    """What the yardstick finds for a closed loop, or for the part of it that was run."""
    key = (job.steps, job.runs)
    if key not in ANSWERS:
        one = contender(yardstick, job, instructions, yardstick)
        if isinstance(one, Missing):
            raise RuntimeError(f"hydroservo cannot do {job.title}: {one.reason}")
        one.worker.close()
    return ANSWERS[key]
