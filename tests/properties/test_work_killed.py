"""Whatever is killed at whatever instant, the parts are those of an undisturbed run, byte for byte."""

import contextlib
import os
import random
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import psutil
import pytest

from hydroservo.work.execution import do_units
from hydroservo.work.units import UnitStore
from tests.support.commands.processes import needs_posix
from tests.support.work.clusters import cluster, replaced
from tests.support.work.units import MANIFEST, contents, units

pytestmark = [needs_posix, pytest.mark.nightly]

COUNT = 60  # units
PATIENCE = 120.0  # s, for what is left when nothing is killed any more
ROOT = Path(__file__).parents[2]
MINE = {"DRIVER_OF": str(os.getpid())}  # in the environment of what these tests start


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    do_units(units(COUNT, seconds=0.0), UnitStore(folder, MANIFEST, {"count": COUNT}), workers=1)
    return contents(folder)


def driver(folder, workers, *scheduler):
    words = [sys.executable, "-m", "tests.support.work.units", folder, COUNT, workers, *scheduler]
    return subprocess.Popen([*map(str, words)], cwd=ROOT, env=os.environ | MINE, stderr=subprocess.DEVNULL)


def alive(processes):
    """Those that were not killed yet."""
    return [one for one in processes if one.is_running() and one.status() != psutil.STATUS_ZOMBIE]


def killed(process, workers):
    """Kill a driver, or more often one of its workers if it has some yet; whom, or None."""
    found = alive(workers())
    if random.random() < 0.3:
        process.kill()
        process.wait()
        return "driver"
    if not found:
        return None
    random.choice(found).kill()
    return "worker"


def disturbed(folder, most, workers, *scheduler, kills):
    """Start a driver again and again, killing it and its workers, until all is done; adds to ``kills``."""
    while True:
        process = driver(folder, 2, *scheduler)
        while process.poll() is None and kills.total() < most:
            time.sleep(random.uniform(0.0, 0.9))
            if process.poll() is None:
                with contextlib.suppress(psutil.NoSuchProcess):
                    kills.update(filter(None, [killed(process, lambda p=process: workers(p))]))
        if process.wait(timeout=PATIENCE) == 0:
            return


def children(process):
    try:
        found = psutil.Process(process.pid).children()
        return [one for one in found if "spawn_main" in " ".join(one.cmdline())]
    except psutil.Error:
        return []


def leaves_no_worker():
    """Whether the processes that the tests' drivers started end with them."""
    until = time.monotonic() + 10.0
    while time.monotonic() < until:
        if not any(map(is_mine, psutil.process_iter())):
            return True
        time.sleep(0.1)
    return False


def is_mine(process):
    try:
        return MINE.items() <= process.environ().items()
    except psutil.Error:
        return False


def test_200_kills_of_drivers_and_workers_change_no_byte(tmp_path, undisturbed):
    kills, rounds = Counter(), 0
    while kills.total() < 200 or min(kills["driver"], kills["worker"]) <= 50:
        folder = tmp_path / str(rounds)
        disturbed(folder, 200, children, kills=kills)
        assert contents(folder) == undisturbed
        rounds += 1
    print(f"{dict(kills)} in {rounds} rounds of {COUNT} units")
    assert leaves_no_worker()


def test_kills_of_drivers_and_workers_on_dask_change_no_byte(tmp_path, undisturbed):
    kills, rounds = Counter(), 0
    with cluster(0) as found, replaced(found.scheduler_address, 2) as workers:
        while kills.total() < 40 or min(kills["driver"], kills["worker"]) <= 5:
            folder = tmp_path / str(rounds)
            disturbed(folder, 40 + 10 * rounds, lambda _: list(workers), found.scheduler_address, kills=kills)
            assert contents(folder) == undisturbed
            rounds += 1
    print(f"{dict(kills)} in {rounds} rounds of {COUNT} units")


def test_two_drivers_at_once_leave_the_same_bytes(tmp_path, undisturbed):
    both = [driver(tmp_path, 2) for _ in range(2)]
    assert [one.wait() for one in both] == [0, 0]
    assert contents(tmp_path) == undisturbed
