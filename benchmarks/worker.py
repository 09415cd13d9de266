"""A process for one contender, so that its threads, settings and memory are its own."""

import math
import multiprocessing
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from benchmarks import isa, peers
from benchmarks.jobs import Job, Result
from benchmarks.peer import Prepared

__all__ = ["Failed", "First", "Worker"]

SHORTEST = 0.02  # s; what takes less is repeated until it takes this long


class First(NamedTuple):
    """What comes of preparing a job and running it once."""

    how: str
    seconds: float  # from nothing but imports, compilation included
    result: Result


class Failed(NamedTuple):
    """A peer that could not do a job."""

    reason: str


class Worker:
    """Runs jobs of one peer in a process of its own, when it is told to."""

    def __init__(self, peer: str, threads: int, instructions: str) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=work, args=(theirs, peer, threads), daemon=True)
        with environment(isa.environment(instructions)):
            self.process.start()
        theirs.close()

    def prepare(self, job: Job) -> First | Failed:
        """Prepares a job, and runs it once."""
        try:
            self.pipe.send(job)
            first: First | Failed = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            return Failed(f"its process ended with exit status {self.process.exitcode}")
        return first

    def seconds(self) -> float:
        """Runs the job again; how long it took."""
        self.pipe.send("again")
        return float(self.pipe.recv())

    def memory(self) -> int | None:
        """The most memory that the process has had so far [byte]; None where the system does not tell."""
        self.pipe.send("memory")
        most: int | None = self.pipe.recv()
        return most

    def close(self) -> None:
        """Ends the process."""
        self.pipe.close()
        self.process.join()


@contextmanager
def environment(changes: dict[str, str]) -> Iterator[None]:
    """Variables that a process started inside finds set."""
    before = dict(os.environ)
    os.environ.update(changes)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def work(pipe: Connection, name: str, threads: int) -> None:
    """The process: answers until the other end is closed."""
    if threads == 1:
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    prepared: Prepared | None = None
    while True:
        try:
            asked = pipe.recv()
        except EOFError:
            return
        if isinstance(asked, Job):
            prepared, first = begun(name, asked)
            pipe.send(first)
        elif asked == "again" and prepared is not None:
            pipe.send(repeated(prepared))
        else:
            pipe.send(peak_memory())


def begun(name: str, job: Job) -> tuple[Prepared | None, First | Failed]:
    """A job made ready, and its first result."""
    began = perf_counter()
    try:
        prepared = peers.named(name).prepare(job)
        result = prepared.run()
    except Exception as error:  # whatever ails a peer is told, and the others go on
        return None, Failed(f"{type(error).__name__}: {error}".splitlines()[0])
    return prepared, First(prepared.how, perf_counter() - began, result)


def repeated(prepared: Prepared) -> float:
    """Seconds of one run, of as many as it takes for the clock to be good enough."""
    repeats, seconds = 1, timed(prepared, 1)
    while repeats * seconds < SHORTEST:
        repeats = max(2 * repeats, math.ceil(SHORTEST / seconds))
        seconds = timed(prepared, repeats)
    return seconds


def timed(prepared: Prepared, repeats: int) -> float:
    """Seconds of one run, on average."""
    began = perf_counter()
    for _ in range(repeats):
        prepared.run()
    return (perf_counter() - began) / repeats


def peak_memory() -> int | None:
    """The largest resident set of this process alone [byte]; getrusage would count its parent's too."""
    status = Path("/proc/self/status")
    found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text(encoding="ascii")) if status.exists() else None
    return 1024 * int(found[1]) if found else None
