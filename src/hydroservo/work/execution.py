"""Does the units that are not done yet: here, in processes that may be killed, or on a cluster."""

import os
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from functools import partial
from multiprocessing import connection, get_context, parent_process
from pathlib import Path
from pickle import UnpicklingError
from threading import Thread
from typing import Any, NamedTuple

from hydroservo._version import __version__
from hydroservo.core.errors import HydroservoError, clipped
from hydroservo.core.outputs import temporary_folder
from hydroservo.work.cores import checked_count
from hydroservo.work.units import Failure, Say, UnitAnswer, UnitAnswers, UnitStore, WorkUnit, answer_to

MOST_DEATHS = 3  # of processes that did one unit, which then is taken for their cause
BLAS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ProcessWorker(NamedTuple):
    """A process, the pipe to it, and what it does."""

    process: Any
    pipe: Any
    unit: WorkUnit


def answers_of_processes(units: Iterable[WorkUnit], count: int, say: Say) -> UnitAnswers:
    """What each unit came to, as they are done.

    A unit whose process ends is done again by another one; after three ends that is its failure.
    """
    with temporary_folder() as folder:
        yield from process_answers(units, count, say, folder)


def process_answers(units: Iterable[WorkUnit], count: int, say: Say, folder: Path) -> UnitAnswers:
    """What each unit came to, by processes whose temporary files are in a folder."""
    waiting, again = iter(units), list[WorkUnit]()
    deaths: Counter[str] = Counter()
    workers: dict[Any, ProcessWorker] = {}

    def go_on(worker: ProcessWorker | None) -> None:
        unit = again.pop() if again else next(waiting, None)
        if unit is not None:
            now = give_unit(worker or new_worker(unit, folder), unit)
            workers[now.pipe] = now
        elif worker is not None:
            worker.pipe.close()  # at which it ends

    try:
        for _ in range(count):
            go_on(None)
        while workers:
            for pipe in connection.wait(list(workers)):
                worker = workers.pop(pipe)
                answer = received_answer(worker)
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


def give_unit(worker: ProcessWorker, unit: WorkUnit) -> ProcessWorker:
    with suppress(OSError):  # its process has just ended, which is seen when its answer is waited for
        worker.pipe.send(partial(answer_to, unit.do, __version__))
    return worker._replace(unit=unit)


def new_worker(unit: WorkUnit, folder: Path) -> ProcessWorker:
    """A worker whose temporary files are in a folder, for it may be killed."""
    context = get_context("spawn")  # a copy would have the locks of this one's threads, without the threads
    here, there = context.Pipe()
    process = context.Process(target=serve_units, args=(there, folder), daemon=True)
    with single_threaded_children():
        process.start()
    there.close()  # so that the end of the process is the end of the pipe
    return ProcessWorker(process, here, unit)


def received_answer(worker: ProcessWorker) -> "UnitAnswer | None":
    """What a worker sent; None if its process ended before."""
    try:
        answer: UnitAnswer = worker.pipe.recv()
    except (EOFError, OSError, UnpicklingError):
        return None
    return answer


def end_of(worker: ProcessWorker) -> str:
    """How a process ended, in words."""
    worker.pipe.close()
    worker.process.kill()
    worker.process.join()
    status = worker.process.exitcode
    return signal.Signals(-status).name if status < 0 else f"status {status}"


def serve_units(pipe: Any, folder: Path) -> None:
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


MOST_SAID = 10  # failures that are said as they happen


class UnitsError(HydroservoError):
    """Some units failed; the others are done."""


def do_units(
    units: Sequence[WorkUnit],
    store: UnitStore,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
    say: Say = lambda _: None,
) -> None:
    """Do the units that are not done, and keep what they come to.

    What is done is kept whatever happens, and the same call goes on from there. Neither where nor by how many
    units are done changes a bit of a part, nor does a worker that dies: its unit is done again.
    """
    count = checked_count(workers, "workers")
    for part in store.damaged:
        say(f"{part}: is damaged, and done again if it is needed")
    done = store.done()
    left = list({unit.key: unit for unit in units if unit.key not in done}.values())
    failures = []
    with closing(unit_answers(left, count, scheduler, say)) as found:
        for number, (unit, answer) in enumerate(found, len(units) - len(left) + 1):
            if isinstance(answer, Failure):
                failures.append(failure_text(unit, answer))
                if len(failures) <= MOST_SAID:
                    say(failures[-1])
            else:
                store.write(unit.key, answer)
            if progress is not None:
                progress(number / len(units))
    if failures:
        raise UnitsError(f"{len(failures):,} of {len(units):,} units failed, such as {clipped(failures[0])}")


def unit_answers(units: Sequence[WorkUnit], workers: int, scheduler: str | None, say: Say) -> UnitAnswers:
    """What each unit came to, as they are done."""
    if not units:
        return
    if scheduler is not None:
        from hydroservo.work.cluster import answers_of_scheduler

        yield from answers_of_scheduler(units, scheduler, say)
    elif workers == 1:
        for unit in units:
            yield unit, answer_to(unit.do, __version__)
    else:
        yield from answers_of_processes(units, min(workers, len(units)), say)


def failure_text(unit: WorkUnit, failure: Failure) -> str:
    """What is to be said of a unit that failed."""
    if failure.defect:
        raise RuntimeError(f"{unit.name}: {failure.text}")
    return f"{unit.name}: {failure.text}"
