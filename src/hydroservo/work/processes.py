"""Units done by processes of this machine, any of which may be killed."""

import os
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import connection, get_context, parent_process
from pathlib import Path
from pickle import UnpicklingError
from threading import Thread
from typing import Any, NamedTuple

from hydroservo._version import __version__
from hydroservo.core.outputs import temporary_folder
from hydroservo.work.unit import Answer, Failure, Say, Unit, answer_to

MOST_DEATHS = 3  # of processes that did one unit, which then is taken for their cause
BLAS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class Worker(NamedTuple):
    """A process, the pipe to it, and what it does."""

    process: Any
    pipe: Any
    unit: Unit


def in_processes(units: Iterable[Unit], count: int, say: Say) -> Generator[tuple[Unit, Answer]]:
    """What each unit came to, as they are done.

    A unit whose process ends is done again by another one; after three ends that is its failure.

    Args:
        units: what is to be done.
        count: of processes.
        say: is told of processes that ended.
    """
    with temporary_folder() as folder:
        yield from in_workers(units, count, say, folder)


def in_workers(units: Iterable[Unit], count: int, say: Say, folder: Path) -> Generator[tuple[Unit, Answer]]:
    """What each unit came to, by processes whose temporary files are in a folder."""
    waiting, again = iter(units), list[Unit]()
    deaths: Counter[str] = Counter()
    workers: dict[Any, Worker] = {}

    def go_on(worker: Worker | None) -> None:
        unit = again.pop() if again else next(waiting, None)
        if unit is not None:
            now = with_unit(worker or new_worker(unit, folder), unit)
            workers[now.pipe] = now
        elif worker is not None:
            worker.pipe.close()  # at which it ends

    try:
        for _ in range(count):
            go_on(None)
        while workers:
            for pipe in connection.wait(list(workers)):
                worker = workers.pop(pipe)
                answer = answer_of(worker)
                if answer is not None:
                    go_on(worker)
                    yield worker.unit, answer
                    continue
                problem = f"its process ended ({end_of(worker)})"
                deaths[worker.unit.key] += 1
                if deaths[worker.unit.key] < MOST_DEATHS:
                    say(f"{worker.unit.name}: {problem}; it is done again")
                    again.append(worker.unit)
                else:
                    yield worker.unit, Failure(f"{problem} for the {MOST_DEATHS}rd time")
                go_on(None)
    finally:
        for worker in workers.values():
            worker.process.kill()
            worker.process.join()


def with_unit(worker: Worker, unit: Unit) -> Worker:
    """A worker that does a unit."""
    with suppress(OSError):  # its process has just ended, which is seen when its answer is waited for
        worker.pipe.send(partial(answer_to, unit.do, __version__))
    return worker._replace(unit=unit)


def new_worker(unit: Unit, folder: Path) -> Worker:
    """A worker whose temporary files are in a folder, for it may be killed."""
    context = get_context("spawn")  # a copy would have the locks of this one's threads, without the threads
    here, there = context.Pipe()
    process = context.Process(target=serve, args=(there, folder), daemon=True)
    with single_threaded_children():
        process.start()
    there.close()  # so that the end of the process is the end of the pipe
    return Worker(process, here, unit)


def answer_of(worker: Worker) -> "Answer | None":
    """What a worker sent; None if its process ended before."""
    try:
        answer: Answer = worker.pipe.recv()
    except (EOFError, OSError, UnpicklingError):
        return None
    return answer


def end_of(worker: Worker) -> str:
    """How a process ended, in words."""
    worker.pipe.close()
    worker.process.kill()
    worker.process.join()
    status = worker.process.exitcode
    return signal.Signals(-status).name if status < 0 else f"status {status}"


def serve(pipe: Any, folder: Path) -> None:
    """Do what comes through a pipe until it is closed: the life of a worker's process."""
    begin_worker(folder)
    while True:
        try:
            do = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(do())


def begin_worker(folder: Path) -> None:
    """Leave the terminal's signals to the first process, end with it, keep temporary files in a folder."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    tempfile.tempdir = str(folder)
    Thread(target=end_with_parent, daemon=True).start()


def end_with_parent() -> None:
    """End when the process does that started this one, killed or not."""
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


@contextmanager
def single_threaded_children() -> Iterator[None]:
    """Processes started inside have one thread each for linear algebra: there is a process for each core."""
    before = {name: os.environ.get(name) for name in BLAS}
    os.environ.update(dict.fromkeys(BLAS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
