"""Units done by the workers of a Dask scheduler, which may be on other machines, and come and go."""

import asyncio
import logging
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from itertools import islice
from time import monotonic
from typing import Any

from hydroservo._version import __version__
from hydroservo.core.errors import HydroservoError, clipped, require
from hydroservo.work.units import Failure, Say, UnitAnswers, WorkUnit, answer_to

PATIENCE = 10  # s, for a scheduler to answer
AHEAD = 3  # units that each thread of a worker is given, so that it never waits for the next
FEWEST = 4  # units handed out while there is no worker
PAUSE = 2.0  # s between two looks at how many threads there are
GLANCE = 0.1  # s between two looks at what is done


def answers_of_scheduler(units: Sequence[WorkUnit], address: str, say: Say) -> UnitAnswers:
    """What each unit came to, as they are done by the workers of a Dask scheduler.

    A few units for each of their threads are handed out at a time. What a worker had that is gone is done by
    another one; a unit at which four of them ended is a failure.
    """
    require("distributed", "cluster", "--scheduler")
    from distributed import as_completed

    with quiet_logs(), connected_client(address) as client:
        waiting, threads = (
            iter(units),
            ClusterThreads(client, lambda: say(f"{address} has no workers; waiting for some")),
        )
        given: dict[str, WorkUnit] = {}
        running = as_completed(loop=client.loop, with_results=True, raise_errors=False)

        def give(unit: WorkUnit) -> None:
            future = client.submit(partial(answer_to, unit.do, __version__), pure=False)
            given[future.key] = unit
            running.add(future)

        try:
            while True:
                for unit in islice(waiting, max(0, threads.count() * AHEAD + FEWEST - len(given))):
                    give(unit)
                if not given:
                    return
                while not running.has_ready():
                    with running.thread_condition:
                        running.thread_condition.wait(GLANCE)
                    threads.count()
                future, result = next(running)
                unit = given.pop(future.key)
                if future.status in ("cancelled", "lost"):  # with the worker, or the scheduler, that had it
                    check_scheduler(address)
                    give(unit)
                    continue
                answer = result if future.status == "finished" else cluster_failure(future.exception())
                del future, result
                yield unit, answer
        finally:
            client.cancel(list(running.futures), force=True)


class ClusterThreads:
    """How many threads the workers of a scheduler have, looked up now and then.

    Args:
        client: of the scheduler.
        none_left: is called when there is no worker, or none any more.
    """

    def __init__(self, client: Any, none_left: Callable[[], None]) -> None:
        self.client, self.none_left = client, none_left
        self.found, self.due = 1, 0.0

    def count(self) -> int:
        if monotonic() >= self.due:
            self.due, before = monotonic() + PAUSE, self.found
            with suppress(OSError):  # of a scheduler that is gone, as its units will tell
                self.found = sum(self.client.nthreads().values())
            if before and not self.found:
                self.none_left()
        return self.found


@contextmanager
def connected_client(address: str) -> Iterator[Any]:
    from distributed import Client

    check_scheduler(address)
    client = Client(address, timeout=PATIENCE, set_as_default=False)
    try:
        yield client
    finally:
        client.close(timeout=PAUSE)


def check_scheduler(address: str) -> None:
    """Ask what listens at an address what it is, from another thread: a notebook's has a loop already."""
    try:
        with ThreadPoolExecutor(1) as pool:
            kind = pool.submit(lambda: asyncio.run(asyncio.wait_for(server_kind(address), PATIENCE))).result()
    except TimeoutError:
        raise HydroservoError(f"no Dask scheduler answers at {address} within {PATIENCE} s") from None
    except Exception as error:  # of the network, of the address, of what answers there and is none of Dask's
        known = isinstance(error, (OSError, ValueError))
        reason = clipped(str(error).partition("\n")[0], 200) if known else "what answers is not Dask's"
        raise HydroservoError(f"no Dask scheduler answers at {address or repr('')}: {reason}") from None
    if kind != "Scheduler":
        raise HydroservoError(f"no Dask scheduler answers at {address}, but a {kind}")


async def server_kind(address: str) -> str:
    from distributed.core import rpc
    from distributed.security import Security

    async with rpc(address, connection_args=Security().get_connection_args("client")) as server:
        return str((await server.identity())["type"])


def cluster_failure(error: BaseException) -> Failure:
    """Why a scheduler has no table of a unit."""
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):
        return Failure(f"{error.allowed_failures + 1} workers ended at it")
    if isinstance(error, ImportError):
        return Failure(f"a worker has not what it needs: {error}; install hydroservo {__version__} there")
    return Failure(f"{type(error).__name__}: {error}", defect=True)


@contextmanager
def quiet_logs() -> Iterator[None]:
    """What the client logs of workers that come and go is not seen inside: it is no matter."""
    logs = [logging.getLogger(f"distributed.{name}") for name in ("client", "core", "comm", "utils")]
    before = [log.level for log in logs]
    for log in logs:
        log.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for log, level in zip(logs, before, strict=True):
            log.setLevel(level)
