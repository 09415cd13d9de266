"""Linear algebra has one thread while something is computed, and what it had once that has ended."""

from collections.abc import Iterator
from pathlib import Path
from threading import Barrier, Thread

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import hydroservo as hs
from hydroservo.work.cores import single_threaded_algebra

ROOT = Path(__file__).parents[2]
RANGE = {"plant.mass": "-40%..+70%"}


def threads() -> set[int]:
    """Of each library of linear algebra."""
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def _two_threads() -> Iterator[None]:
    with single_threaded_algebra():  # which loads the libraries
        pass
    with threadpool_limits(2, "blas"):
        yield


def test_what_there_was_is_there_again_after_contexts_that_overlap() -> None:
    entered, left = Barrier(2), Barrier(2)

    def first() -> None:
        with single_threaded_algebra():
            entered.wait()
        left.wait()

    thread = Thread(target=first)
    thread.start()
    with single_threaded_algebra():
        entered.wait()
        left.wait()
        assert threads() == {1}
    thread.join()
    assert threads() == {2}


@pytest.mark.parametrize(
    "compute",
    [
        lambda report: hs.bode(hs.load_scenario("rig/1khz-pi-sine"), measure=False, progress=report),
        lambda report: hs.tune("rig/1khz-pi-sine", candidates=64, bounded=False, progress=report),
        lambda report: hs.identify(
            "rig/1khz-pi-square", ROOT / "examples/bench_log.csv", RANGE, progress=report
        ),
    ],
    ids=["bode", "tune", "identify"],
)
def test_what_solves_many_small_systems_takes_one_thread(compute) -> None:
    seen: list[set[int]] = []
    compute(lambda *_: seen.append(threads()))
    assert seen
    assert all(one == {1} for one in seen)
    assert threads() == {2}
