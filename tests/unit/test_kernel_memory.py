"""Kernels touch the memory made for them and nothing else, and take no other."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.core.block import Block
from hydroservo.core.errors import LoopError
from hydroservo.core.time_series import TimeSeries
from hydroservo.engine import flat
from hydroservo.engine.kernel import check_rows
from hydroservo.engine.native import c_argument
from hydroservo.testing.examples import example

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]

posix = pytest.mark.skipif(os.name != "posix", reason="mprotect is POSIX")


def in_guarded_memory(what: str, edge: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tests.support.guarded", what, edge]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)


@posix
@pytest.mark.parametrize("edge", ["start", "end"])
@pytest.mark.parametrize("what", ["run", "lanes"])
def test_a_kernel_stays_in_its_memory(what: str, edge: str) -> None:
    done = in_guarded_memory(what, edge)
    assert done.returncode == 0, done.stderr
    assert "arrays guarded" in done.stdout


@posix
def test_a_guard_is_felt() -> None:
    assert in_guarded_memory("beyond", "end").returncode == -signal.SIGSEGV


@pytest.mark.parametrize(
    ("first", "last", "stride", "rows"),
    [
        (0, 10, 1, 9),
        (0, 10, 3, 3),
        (0, 1, 2**62, 0),
        (5, 10, 3, 1),
        (0, 0, 0, 9),
        (3, 2, 1, 9),
        (-1, 2, 1, 9),
    ],
)
def test_rows_that_do_not_fit_are_refused(first: int, last: int, stride: int, rows: int) -> None:
    with pytest.raises(ValueError, match=r"samples|do not fit"):
        check_rows(first, last, stride, np.zeros((rows, 2)), 2)


@pytest.mark.parametrize(("first", "last", "stride", "rows"), [(0, 10, 3, 4), (4, 6, 3, 0), (5, 10, 3, 2)])
def test_rows_that_fit_are_taken(first: int, last: int, stride: int, rows: int) -> None:
    check_rows(first, last, stride, np.zeros((rows + 1, 2))[:rows], 2)


@pytest.mark.parametrize(
    "out",
    [np.zeros((10, 2), np.float32), np.zeros((2, 10)).T, np.zeros((20, 2))[::2], np.zeros((10, 4))[:, :2]],
    ids=["single precision", "by columns", "every second", "wider"],
)
def test_rows_of_other_numbers_are_refused(out: np.ndarray) -> None:
    with pytest.raises(ValueError, match="contiguous"):
        check_rows(0, 10, 1, out, 2)


def read_only() -> np.ndarray:
    array = np.zeros(2)
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    "array",
    [np.zeros(2, np.float32), np.zeros(4)[::2], np.zeros(2, ">f8"), np.zeros(2, bool), read_only()],
    ids=["single precision", "every second", "of other byte order", "truths", "read-only"],
)
def test_other_arrays_reach_no_kernel(array: np.ndarray) -> None:
    with pytest.raises(TypeError, match="contiguous"):
        c_argument(array)


@pytest.mark.parametrize("number", [2**63, -(2**63) - 1, 10**40])
def test_a_number_beyond_64_bits_reaches_no_kernel(number: int) -> None:
    with pytest.raises(OverflowError):
        c_argument(number)


@pytest.mark.parametrize("knots", [np.arange(2, dtype=np.float32), np.arange(4.0)[::2]])
def test_other_arrays_of_a_block_reach_no_kernel(knots: np.ndarray) -> None:
    with pytest.raises(TypeError, match="knots must be a contiguous array of doubles"):
        flat.block_arrays(TimeSeries(knots))


@pytest.mark.parametrize("seconds", [1.0, 1.8446744073709552e14, 1e15, 1e20, 1e300])
def test_a_record_period_beyond_the_run_leaves_the_start(seconds: float) -> None:
    loop = example(Loop, Simulation(0.01, 1e-3))
    data = simulate(replace(loop, {"simulation.record_period": seconds}))
    assert data.time.values.tolist() == [0.0]
    assert float(data["plant.position"][0]) == float(simulate(loop)["plant.position"][0])


class TableState(NamedTuple):
    u: float
    samples: float


class Table(NamedTuple):
    """A law with a table of its own, and an index that moves on with each sample."""

    step_of_index: float = 0.0
    knots: np.ndarray = np.ones(3)  # of which a kernel is told the length when it runs

    def init(self) -> TableState:
        return TableState(0.0, 0.0)

    def step(self, s: Block, y: Any, r: Any, dt: float) -> TableState:
        i = 0
        while i + 1 <= self.step_of_index * s.samples:
            i += 1
        return TableState(float(self.knots[i]), s.samples + 1.0)


def test_an_index_inside_a_table_serves() -> None:
    loop = example(Loop, Simulation(0.01, 1e-3), controller=Table(0.2))
    assert simulate(loop, strict=True).identical(simulate(loop, compiled=False))


@pytest.mark.parametrize("step", [0.5, 3.0, 1e5])
def test_an_index_outside_a_table_stops_the_run(step: float) -> None:
    loop = example(Loop, Simulation(0.01, 1e-3), controller=Table(step))
    with pytest.raises(LoopError, match="stopped: a block raised an exception"):
        simulate(loop)
