"""The machinery that lets one text run in plain Python and compiled."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import config
from numba.core.errors import TypingError

from hydroservo import ops
from hydroservo.block import Block
from hydroservo.engine.integrators import RK4
from hydroservo.engine.jit import compiled
from hydroservo.engine.kernel import compiled_kernel, interpreted_kernel
from hydroservo.engine.tree import axpy, reader, recorder

about_compilation = pytest.mark.skipif(
    bool(config.DISABLE_JIT), reason="says what numba compiles, and nothing is compiled here"
)


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

    limit: float = 1e3

    def sample(self, s: Inner, t: float, dt: float) -> Inner:
        return Inner(s.a, t)

    def machine(self, s: Inner) -> Inner:
        return s

    def command(self, s: Inner) -> float:
        return 0.0

    def deriv(self, t: float, x: Inner, u: float) -> Inner:
        return Inner(u - x.a, 0.0)

    def moved(self, s: Inner, x: Inner) -> Inner:
        return x

    def finite(self, x: Inner) -> bool:
        return ops.absolute(x.a) < self.limit


class Count(NamedTuple):
    """Counts samples."""

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
            np.zeros((2, 2)),
        )
        first, nothing, last = read(STATE)
        assert (first, last) == (3.0, 2.0)
        assert np.isnan(nothing)
        record(out, 1, STATE)
        assert out.tolist() == [[0.0, 0.0], [1.0, 3.0]]


KERNELS = [interpreted_kernel, compiled_kernel]


def start(make: Any, rows: int) -> tuple[Any, np.ndarray]:
    return make(Inner, ("b", "a"), ("a", "b")), np.full((rows, 2), np.nan)


@pytest.mark.parametrize("make", KERNELS)
def test_the_kernel_records_every_third_sample(make: Any) -> None:
    kernel, out = start(make, 4)
    s, m, finite = kernel(Decay(), RK4(2), Count(), Inner(1.0, 0.0), Inner(0.0, 0.0), 0, 10, 0.1, 3, out)
    assert finite
    assert m == Inner(10.0, 9 * 0.1)
    assert out[:, 0].tolist() == [0.0, 3 * 0.1, 6 * 0.1, 9 * 0.1]
    assert out[:, 1] == pytest.approx(np.exp([0.0, -0.3, -0.6, -0.9]), rel=1e-7)
    assert s.a == pytest.approx(np.exp(-1.0), rel=1e-7)


@pytest.mark.parametrize("make", KERNELS)
def test_the_kernel_goes_on_from_a_sample(make: Any) -> None:
    kernel, out = start(make, 4)
    s, m, _ = kernel(Decay(), RK4(1), Count(), Inner(1.0, 0.0), Inner(0.0, 0.0), 0, 10, 0.1, 3, out)
    kernel, again = start(make, 4)
    middle, count, _ = kernel(Decay(), RK4(1), Count(), Inner(1.0, 0.0), Inner(0.0, 0.0), 0, 5, 0.1, 3, again)
    end, count, _ = kernel(Decay(), RK4(1), Count(), middle, count, 5, 10, 0.1, 3, again[2:])
    assert (end, count) == (s, m)
    assert again.tolist() == out.tolist()


@pytest.mark.parametrize("make", KERNELS)
def test_the_kernel_stops_where_the_state_is_lost(make: Any) -> None:
    kernel, out = start(make, 10)
    growing = (Decay(1e3), RK4(1), Count(), Inner(1.0, 0.0), Inner(0.0, 0.0), 0, 10, 5.0, 1, out)
    s, m, finite = kernel(*growing)
    assert not finite
    assert abs(s.a) > 1e3
    assert m.a == np.isfinite(out[:, 1]).sum() == 3


def test_kernels_of_both_modes_are_the_same_bits() -> None:
    results = []
    for make in KERNELS:
        kernel, out = start(make, 100)
        done = kernel(Decay(), RK4(3), Count(), Inner(1.0, 0.0), Inner(0.0, 0.0), 0, 100, 0.0137, 1, out)
        results.append((*done, out.tobytes()))
    assert results[0] == results[1]


def test_one_kernel_serves_all_gains() -> None:
    assert compiled_kernel(Inner, ("a",), ("b",)) is compiled_kernel(Inner, ("a",), ("b",))


@about_compilation
def test_new_gains_do_not_compile_anew_and_new_types_do() -> None:
    call = compiled(Holder.apply)
    for gain in (1.0, 2.0):
        call(Holder(gain), 1.0)
    assert len(call.signatures) == 1  # type: ignore[attr-defined]
    assert call(Holder(3.0, OtherLaw()), 5.0) == 61.0
    assert len(call.signatures) == 2  # type: ignore[attr-defined]


@about_compilation
def test_an_unknown_method_is_a_typing_error() -> None:
    def call(block: Law) -> float:
        return block.triple(1.0)  # type: ignore[attr-defined, no-any-return]

    with pytest.raises(TypingError, match="triple"):
        compiled(call)(Law())
