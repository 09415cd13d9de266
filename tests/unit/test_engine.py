"""The machinery that lets one text run in plain Python and compiled."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest

from hydroservo import ops
from hydroservo.core.block import Block, leaves
from hydroservo.core.roles import at_samples
from hydroservo.core.states import axpy, filled
from hydroservo.engine.compiling import compiled_function
from hydroservo.engine.flat import checker, recorder
from hydroservo.engine.kernel import CompiledRun, InterpretedRun, Recording, RunSpec
from hydroservo.engine.native import CompileError, RunError
from hydroservo.engine.watch import monitor_groups, spans_of
from hydroservo.machine.integrators import RK4, Tsit5


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

    def with_machine(self, s: Inner, x: Inner) -> Inner:
        return x

    def between(self, s: Inner, x: Inner, t: float) -> Inner:
        return Inner(x.a, t)


@at_samples
class Count(NamedTuple):
    """Counts samples, and keeps when the last one was."""

    def init(self) -> Inner:
        return Inner(0.0, 0.0)

    def step(self, m: Inner, loop: Block, s: Inner, t: float, dt: float) -> Inner:
        return Inner(m.a + 1.0, s.b)


class Heard(NamedTuple):
    steps: float
    area: float  # under a, by the left rule
    time: float
    last: float


class Area(NamedTuple):
    """Counts the integrator's steps, and adds up a dt and dt."""

    def init(self) -> Heard:
        return Heard(0.0, 0.0, 0.0, 0.0)

    def step(self, m: Heard, loop: Block, s: Inner, t: float, dt: float) -> Heard:
        return Heard(m.steps + 1.0, m.area + s.a * dt, m.time + dt, t)


STATE = Outer(Inner(1.0, 2.0), 3.0)
RATE = Outer(Inner(10.0, 20.0), 30.0)


@pytest.mark.parametrize("mode", [lambda f: f, compiled_function], ids=["interpreted", "compiled"])
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

    def test_a_recorder_takes_paths_of_the_state_and_of_the_monitors(self, mode: Any) -> None:
        record, out = mode(recorder(["s.inner.a", "m.b"])), np.zeros(4)
        record(out, 1, STATE, Inner(5.0, 6.0))
        assert out.tolist() == [0.0, 0.0, 1.0, 6.0]

    def test_a_checker_finds_what_is_not_finite_or_beyond_reach(self, mode: Any) -> None:
        holds = mode(checker(["inner.a", "c"], {"c": 3.0}))
        assert holds(STATE)
        for lost in (math.nan, math.inf, -math.inf):
            assert not holds(Outer(Inner(lost, 2.0), 3.0))
            assert holds(Outer(Inner(1.0, lost), 3.0))
        assert not holds(Outer(Inner(1.0, 2.0), 3.0000001))
        assert not holds(Outer(Inner(1.0, 2.0), -3.0000001))


RUNS = {"interpreted": InterpretedRun, "compiled": partial(CompiledRun, strict=True)}
START = Inner(1.0, 0.0)
WANTED = Recording(("s.b", "s.a"), ("a",), ())
MONITORS = {"count": Count(), "area": Area(), "again": Count()}
ENDLESS = 10**9  # periods
DECAY, EQUAL_STEPS = Decay(), RK4()


def study(
    substeps: int = 2, periods: int = ENDLESS, system: Block = DECAY, integrator: Block = EQUAL_STEPS
) -> RunSpec:
    return RunSpec(system, integrator, periods, substeps, monitor_groups(MONITORS))


def heard(run: InterpretedRun | CompiledRun) -> dict[str, Block]:
    """What each monitor gathered."""
    numbers = [number for _, number in leaves(run.sums)]
    spans = spans_of(MONITORS)
    return {name: filled(one.init(), iter(numbers[spans[name]])) for name, one in MONITORS.items()}


@pytest.fixture(params=RUNS)
def make(request: pytest.FixtureRequest) -> Callable[..., InterpretedRun | CompiledRun]:
    """Starts a run of a decay that records b and a, and watches a."""

    def started(substeps: int = 2, periods: int = ENDLESS) -> InterpretedRun | CompiledRun:
        run: InterpretedRun | CompiledRun = RUNS[request.param](study(substeps, periods), WANTED, START)
        return run

    return started


def rows(count: int) -> np.ndarray:
    return np.full((count, 2), np.nan)


def test_a_run_records_every_third_sample(make: Any) -> None:
    run, out = make(), rows(4)
    assert run.advance(0, 10, 0.1, 3, out) == 10
    assert heard(run)["count"] == heard(run)["again"] == Inner(10.0, 9 * 0.1)
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
    assert heard(run)["count"].a == np.isfinite(out[:, 1]).sum() == 2


def test_a_run_hears_each_step_at_its_instant_and_the_end_once(make: Any) -> None:
    """The state that is heard is that of the instant: a's left sum over the substeps is that of e^-t."""
    run, out = make(substeps=4, periods=10), rows(11)
    assert run.advance(0, 11, 0.1, 1, out) == 11
    found = heard(run)["area"]
    assert (found.steps, found.last) == (41.0, 1.0)
    assert found.time == pytest.approx(1.0, rel=1e-14)
    instants = 0.025 * np.arange(40)
    assert found.area == pytest.approx(0.025 * np.exp(-instants).sum(), rel=1e-7)
    assert out[-1, 1] == run.state.a == pytest.approx(np.exp(-1.0), rel=1e-7)


def test_the_last_sample_is_the_end(make: Any) -> None:
    """No motion comes after it: the state is as it was recorded there."""
    run, out = make(periods=1), rows(2)
    assert run.advance(0, 2, 1e50, 1, out) == 0
    run, out = make(periods=0), rows(1)
    assert run.advance(0, 1, 1e50, 1, out) == 1
    assert run.state == Inner(1.0, 0.0)


@pytest.mark.parametrize("integrator", [RK4(), Tsit5()])
def test_runs_of_both_modes_are_the_same_bits(integrator: Block) -> None:
    results = []
    for started in RUNS.values():
        run, out = (
            started(study(3, 99, integrator=integrator), WANTED, START),
            rows(100),
        )
        run.advance(0, 100, 0.0137, 1, out)
        results.append((run.state, run.sums, out.tobytes()))
    assert results[0] == results[1]


def test_one_kernel_serves_all_gains() -> None:
    runs = [CompiledRun(study(1, system=Decay(rate)), WANTED, START, strict=True) for rate in (1.0, 2.0)]
    assert runs[0].call is runs[1].call


class Shouting(NamedTuple):
    """A system whose method raises: it reads beyond the end of an array."""

    rate: float = 1.0
    knots: Any = np.zeros(2)

    def sample(self, s: Inner, t: float, dt: float) -> Inner:
        total = 0.0
        for i in range(self.knots.size + 1):
            total += self.knots[i]
        return Inner(s.a + total, s.b)

    machine, held, with_machine, between = Decay.machine, Decay.held, Decay.with_machine, Decay.between
    deriv, next_jump = Decay.deriv, Decay.next_jump


def test_an_exception_inside_compiled_code_is_an_error() -> None:
    run = CompiledRun(study(1, system=Shouting()), WANTED, START, strict=True)
    with pytest.raises(RunError, match="raised an exception"):
        run.advance(0, 1, 0.1, 1, rows(1))


def test_new_gains_do_not_compile_anew_and_new_types_do() -> None:
    call = compiled_function(Holder.apply)
    for gain in (1.0, 2.0):
        call(Holder(gain), 1.0)
    assert len(call.kernels) == 1
    assert call(Holder(3.0, OtherLaw()), 5.0) == 61.0
    assert len(call.kernels) == 2


def test_an_unknown_method_is_an_error() -> None:
    def call(block: Law) -> float:
        return block.triple(1.0)  # type: ignore[attr-defined, no-any-return]

    with pytest.raises(CompileError, match="triple"):
        compiled_function(call)(Law())
