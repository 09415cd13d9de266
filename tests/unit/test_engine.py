"""The machinery that lets one text run in plain Python and compiled."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba.core.errors import TypingError

from hydroservo import ops
from hydroservo.block import Block
from hydroservo.engine.compiling import compiled
from hydroservo.engine.flat import reader, recorder
from hydroservo.engine.kernel import CompiledRun, InterpretedRun, Study, Wanted
from hydroservo.engine.native import RunError
from hydroservo.integrators import RK4
from hydroservo.states import axpy


class Inner(NamedTuple):
    a: float
    b: float


class Outer(NamedTuple):
    inner: Inner
    c: float


class Empty(NamedTuple):
    """A state that remembers nothing."""


class Law(NamedTuple):
    """A block without parameters."""

    def double(self, x: float) -> float:
        return 2.0 * x


class OtherLaw(NamedTuple):
    """Another block of the same role."""

    def double(self, x: float) -> float:
        return 4.0 * x


class Holder(NamedTuple):
    gain: float
    law: Block = Law()

    def apply(self, x: float) -> float:
        return self.gain * self.law.double(x) + self.offset(x)

    def offset(self, x: float) -> float:
        return ops.where(x > 0.0, 1.0, -1.0)


class Decay(NamedTuple):
    """dx/dt = -x + u, sampled; the smallest system that the kernel runs."""

    rate: float = 1.0

    def sample(self, s: Inner, t: float, dt: float) -> Inner:
        return Inner(s.a, t)

    def machine(self, s: Inner) -> Inner:
        return s

    def held(self, s: Inner) -> float:
        return 0.0

    def deriv(self, t: float, x: Inner, u: float) -> Inner:
        return Inner(u - self.rate * x.a, 0.0)

    def next_jump(self, t: float, u: float) -> float:
        return math.inf

    def moved(self, s: Inner, x: Inner) -> Inner:
        return x


class Count(NamedTuple):
    """Counts samples."""

    def init(self) -> Inner:
        return Inner(0.0, 0.0)

    def step(self, s: Inner, t: float, v: Any) -> Inner:
        return Inner(s.a + 1.0, v.b)


STATE = Outer(Inner(1.0, 2.0), 3.0)
RATE = Outer(Inner(10.0, 20.0), 30.0)


@pytest.mark.parametrize("mode", [lambda f: f, compiled], ids=["interpreted", "compiled"])
class TestBothModes:
    def test_a_method_calls_its_own_and_nested_methods(self, mode: Any) -> None:
        def call(block: Holder, x: float) -> float:
            return block.apply(x)

        assert mode(call)(Holder(3.0), 5.0) == 31.0
        assert mode(call)(Holder(3.0), -5.0) == -31.0

    def test_axpy_over_a_nested_state(self, mode: Any) -> None:
        def call(x: Outer, h: float, k: Outer) -> Outer:
            return axpy(x, h, k)

        assert mode(call)(STATE, 0.5, RATE) == Outer(Inner(6.0, 12.0), 18.0)

    def test_axpy_over_a_state_of_nothing(self, mode: Any) -> None:
        def call(x: Empty, h: float, k: Empty) -> Empty:
            return axpy(x, h, k)

        assert mode(call)(Empty(), 0.5, Empty()) == Empty()

    def test_reader_and_recorder_take_paths(self, mode: Any) -> None:
        read, record, out = (
            mode(reader(["c", None, "inner.b"])),
            mode(recorder(["inner.a", "c"])),
            np.zeros(4),
        )
        first, nothing, last = read(STATE)
        assert (first, last) == (3.0, 2.0)
        assert np.isnan(nothing)
        record(out, 1, STATE)
        assert out.tolist() == [0.0, 0.0, 1.0, 3.0]


RUNS = {"interpreted": InterpretedRun, "compiled": partial(CompiledRun, strict=True)}
START = Inner(1.0, 0.0)
WANTED = Wanted(("b", "a"), ("a", "b"), Inner, ("a",))


@pytest.fixture(params=RUNS)
def make(request: pytest.FixtureRequest) -> Callable[..., InterpretedRun | CompiledRun]:
    """Starts a run of a decay that records b and a, measures a and b, and watches a."""

    def started(substeps: int = 2) -> InterpretedRun | CompiledRun:
        study = Study(Decay(), RK4(), substeps, Count())
        run: InterpretedRun | CompiledRun = RUNS[request.param](study, WANTED, START)
        return run

    return started


def rows(count: int) -> np.ndarray:
    return np.full((count, 2), np.nan)


def test_a_run_records_every_third_sample(make: Any) -> None:
    run, out = make(), rows(4)
    assert run.advance(0, 10, 0.1, 3, out) == 10
    assert run.sums == Inner(10.0, 9 * 0.1)
    assert out[:, 0].tolist() == [0.0, 3 * 0.1, 6 * 0.1, 9 * 0.1]
    assert out[:, 1] == pytest.approx(np.exp([0.0, -0.3, -0.6, -0.9]), rel=1e-7)
    assert run.state.a == pytest.approx(np.exp(-1.0), rel=1e-7)


def test_a_run_goes_on_from_a_sample(make: Any) -> None:
    whole, cut, out, again = make(), make(), rows(4), rows(4)
    whole.advance(0, 10, 0.1, 3, out)
    cut.advance(0, 5, 0.1, 3, again)
    cut.advance(5, 10, 0.1, 3, again[2:])
    assert (cut.state, cut.sums) == (whole.state, whole.sums)
    assert again.tolist() == out.tolist()


def test_a_run_stops_where_the_state_is_lost(make: Any) -> None:
    run, out = make(substeps=1), rows(10)
    assert run.advance(0, 10, 1e50, 1, out) == 1
    assert not math.isfinite(run.state.a)
    assert run.sums.a == np.isfinite(out[:, 1]).sum() == 2


def test_runs_of_both_modes_are_the_same_bits() -> None:
    results = []
    for started in RUNS.values():
        run, out = (
            started(Study(Decay(), RK4(), 3, Count()), WANTED, START),
            rows(100),
        )
        run.advance(0, 100, 0.0137, 1, out)
        results.append((run.state, run.sums, out.tobytes()))
    assert results[0] == results[1]


def test_one_kernel_serves_all_gains() -> None:
    runs = [
        CompiledRun(Study(Decay(rate), RK4(), 1, Count()), WANTED, START, strict=True) for rate in (1.0, 2.0)
    ]
    assert runs[0].call is runs[1].call


class Shouting(NamedTuple):
    """A system whose method raises."""

    rate: float = 1.0

    def sample(self, s: Inner, t: float, dt: float) -> Inner:
        if s.a > 0.0:
            raise ValueError("no")
        return s

    machine, held, moved = Decay.machine, Decay.held, Decay.moved
    deriv, next_jump = Decay.deriv, Decay.next_jump


def test_an_exception_inside_compiled_code_is_an_error() -> None:
    run = CompiledRun(Study(Shouting(), RK4(), 1, Count()), WANTED, START, strict=True)
    with pytest.raises(RunError, match="raised an exception"):
        run.advance(0, 1, 0.1, 1, rows(1))


def test_new_gains_do_not_compile_anew_and_new_types_do() -> None:
    call = compiled(Holder.apply)
    for gain in (1.0, 2.0):
        call(Holder(gain), 1.0)
    assert len(call.signatures) == 1  # type: ignore[attr-defined]
    assert call(Holder(3.0, OtherLaw()), 5.0) == 61.0
    assert len(call.signatures) == 2  # type: ignore[attr-defined]


def test_an_unknown_method_is_a_typing_error() -> None:
    def call(block: Law) -> float:
        return block.triple(1.0)  # type: ignore[attr-defined, no-any-return]

    with pytest.raises(TypingError, match="triple"):
        compiled(call)(Law())
