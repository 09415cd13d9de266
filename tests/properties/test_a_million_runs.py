"""A million runs on a Dask cluster: none is lost, memory is flat meanwhile, and what the way there costs.

Times of processors are printed: what else a machine does, and what its cores share, moves them more than what
is asked here. What Dask takes by itself is measured on a cluster that rests.
"""

import contextlib
import json
import subprocess
import time

import numpy as np
import psutil
import pyarrow.parquet as pq
import pytest

from tests.support.commands.processes import HYDROSERVO
from tests.support.work.clusters import cluster, workers_of
from tests.support.work.units import contents

pytestmark = pytest.mark.nightly

RUNS, PARTS = 1_000_000, 62
BATCH = (
    *("batch", "paper/sine-pi", "--runs", str(RUNS), "--vary", "plant.mass=4..8kg", "--json"),
    *("--set", "simulation.period=1 ms", "--set", "simulation.duration=99 ms"),  # 100 samples
)
MIB = 2**20


class Watched:
    """A command, the time of processors that it and others took, and the memory they held meanwhile.

    Attributes:
        wall: how long it took [s].
        processor: how long all processors worked for it [s], its own first; the last of the others is this
            process, less what watching takes.
        memory: of it and the others, while there were parts to come, sampled over time [MiB].
        last: the most that the command itself held after that.
        said: on stdout.
    """

    def __init__(self, folder, options, others=()):
        words = [*HYDROSERVO, *BATCH, "--out", f"{folder}/", *options]
        before, start, watching = [*map(seconds_of, others)], time.monotonic(), time.thread_time()
        self.memory, self.last, own = [], 0.0, 0.0
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
            driver = psutil.Process(process.pid)
            while process.poll() is None:
                with contextlib.suppress(psutil.Error):
                    own = seconds_of(driver)
                    held = [one.memory_info().rss / MIB for one in (driver, *others)]
                    if len(list(folder.glob("parts/*"))) < PARTS:
                        self.memory.append(held)
                    else:
                        self.last = max(self.last, held[0])
                time.sleep(0.2)
            self.said = process.stdout.read()
        assert process.returncode == 0
        self.wall = time.monotonic() - start
        after = map(seconds_of, others)
        self.processor = [own, *(now - then for now, then in zip(after, before, strict=True))]
        if others:
            self.processor[-1] -= time.thread_time() - watching


def seconds_of(process):
    times = process.cpu_times()
    return times.user + times.system


def test_a_million_runs_lose_nothing_and_keep_memory_flat(tmp_path):
    with cluster(2) as found:
        there = ("--scheduler", found.scheduler_address)
        Watched(tmp_path / "warm", [*there, "--runs", "33000"])
        dask = Watched(tmp_path / "dask", there, [*workers_of(found), psutil.Process()])
    threads = Watched(tmp_path / "threads", ["--threads", "2"])
    for name, one in (("Dask", dask), ("threads", threads)):
        each = ", ".join(f"{seconds:.1f}" for seconds in one.processor)
        print(f"{name}: {one.wall:.1f} s, {sum(one.processor):.1f} s of processors ({each})")
    thirds = [part.max(axis=0).round() for part in np.array_split(np.array(dask.memory), 3)]
    print(f"MiB of driver, workers, scheduler in thirds of the time: {[list(map(int, t)) for t in thirds]}")
    print(f"MiB of driver in the end: {dask.last:.0f}")
    runs = pq.read_table(tmp_path / "dask" / "parts", columns=["run"]).column("run").to_numpy()
    assert np.array_equal(np.sort(runs), np.arange(RUNS))
    assert contents(tmp_path / "dask") == contents(tmp_path / "threads")
    assert json.loads(dask.said) == json.loads(threads.said)
    assert (thirds[2] <= 1.1 * thirds[1]).all()


def test_a_cluster_that_rests_takes_next_to_nothing():
    """By Dask's own settings a worker takes four hundredths of a core, and the scheduler more."""
    with cluster(2) as found:
        time.sleep(2.0)  # until it has started
        processes, start = [*workers_of(found), psutil.Process()], time.monotonic()
        before = [*map(seconds_of, processes)]
        time.sleep(8.0)
        seconds = time.monotonic() - start
        taken = [(seconds_of(one) - then) / seconds for one, then in zip(processes, before, strict=True)]
    print(f"of a core, each worker and the scheduler: {[round(one, 3) for one in taken]}")
    assert max(taken) < 0.02
