"""Dask clusters on this machine, of processes that may be killed."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import dask
import psutil
from distributed import LocalCluster

SETTINGS = Path(__file__).parents[3] / "examples" / "dask.yaml"


@contextmanager
def cluster(workers: int = 2) -> Iterator[LocalCluster]:
    """A scheduler in this process, and so many workers of one thread each in others, set as in the manual."""
    settings = dask.config.merge(dask.config.config, dask.config.collect([str(SETTINGS)], env={}))
    with (
        dask.config.set(settings),
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            host="127.0.0.1",
            silence_logs=60,
        ) as found,
    ):
        yield found


def workers_of(found: LocalCluster) -> list[psutil.Process]:
    """The processes of the workers that its scheduler knows."""
    pids = [state.pid for state in found.scheduler.workers.values()]
    return [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]


@contextmanager
def replaced(address: str, count: int) -> Iterator[list[psutil.Popen]]:
    """So many workers of a scheduler, each replaced when it ends; Dask's nanny gives up one killed early."""
    words = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1"]
    workers, ended = [], threading.Event()

    def keep() -> None:
        while not ended.wait(0.1):
            workers[:] = [one for one in workers if one.poll() is None]
            while len(workers) < count:
                workers.append(psutil.Popen([*words, "--no-dashboard"], stderr=subprocess.DEVNULL))

    keeper = threading.Thread(target=keep)
    keeper.start()
    try:
        yield workers
    finally:
        ended.set()
        keeper.join()
        for one in workers:
            one.kill()
            one.wait()
