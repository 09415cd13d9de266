"""The functions of ops over all 64-bit floats: one meaning in both modes, and the right one."""

import math
import struct
from collections.abc import Callable
from functools import cache
from typing import Any

import mpmath
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from hydroservo import ops
from hydroservo.engine.compiling import compiled_function
from hydroservo.engine.flat import text_function

ULP = 2.0**-52  # relative
LEAST_NORMAL = 2.0**-1022
ARGUMENTS = {
    "absolute": "x",
    "clip": "xxx",
    "copysign": "xx",
    "cos": "x",
    "floor": "x",
    "isfinite": "x",
    "isnan": "x",
    "maximum": "xx",
    "minimum": "xx",
    "nearest": "n",
    "normal": "wsw",
    "power": "xx",
    "power_root": "xlfe",
    "at_or_after": "xx",
    "reached": "xx",
    "sign": "x",
    "signed_power": "xx",
    "sin": "x",
    "smooth_root": "xx",
    "sqrt": "x",
    "square_wave": "tp",
    "tanh": "x",
    "uniform": "wsw",
    "where": "bxx",
}
VALUES = {
    "b": st.booleans(),
    "e": st.floats(0.1, 0.99),
    "f": st.floats(0.0, 1e9),
    "l": st.floats(1.0, 1e9),
    "n": st.floats(-(2.0**50), 2.0**50),
    "p": st.floats(1e-9, 1e9),
    "s": st.integers(0, 2**32 - 1).map(float),
    "t": st.floats(),
    "w": st.integers(0, 2**53 - 1).map(float),
    "x": st.one_of(
        st.floats(), st.floats(-1e3, 1e3), st.sampled_from([0.0, -0.0, 0.5, 1.0, -1.0, 2.0, -3.0])
    ),
}

anything = st.floats()
finite = st.floats(allow_nan=False, allow_infinity=False)


def same(a: Any, b: Any) -> bool:
    """Bit for bit; all nan are one."""
    if isinstance(a, float) and math.isnan(a):
        return isinstance(b, float) and math.isnan(b)
    return type(a) is type(b) and (
        struct.pack("<d", a) == struct.pack("<d", b) if isinstance(a, float) else a == b
    )


@cache
def compiled_op(name: str) -> Callable[..., Any]:
    """An op called from compiled code, as blocks call it."""
    names = ", ".join("abcd"[: len(ARGUMENTS[name])])
    namespace: dict[str, Any] = {"ops": ops}
    return compiled_function(
        text_function(f"def call({names}): return ops.{name}({names})", namespace, "call")
    )


def test_every_op_is_tested() -> None:
    assert set(ARGUMENTS) == set(ops.__all__)


@pytest.mark.parametrize("name", ops.__all__)
@given(data=st.data())
def test_interpreted_and_compiled_are_the_same_bits(name: str, data: st.DataObject) -> None:
    values = [data.draw(VALUES[kind]) for kind in ARGUMENTS[name]]
    expected = getattr(ops, name)(*values)
    got = compiled_op(name)(*values)
    assert same(expected, got), (values, expected, got)


@given(x=anything)
def test_comparisons_without_a_branch(x: float) -> None:
    assert ops.isnan(x) == math.isnan(x)
    assert ops.isfinite(x) == math.isfinite(x)
    assert same(ops.absolute(x), abs(x))
    assert ops.sign(x) == (0.0 if math.isnan(x) else float((x > 0) - (x < 0)))


@given(a=anything, b=anything)
def test_minimum_and_maximum(a: float, b: float) -> None:
    if math.isnan(a) or math.isnan(b):
        assert same(ops.minimum(a, b), b)
        assert same(ops.maximum(a, b), b)
    else:
        assert ops.minimum(a, b) == min(a, b)
        assert ops.maximum(a, b) == max(a, b)


@given(x=anything, limits=st.tuples(finite, finite).map(sorted))
def test_clip(x: float, limits: list[float]) -> None:
    low, high = limits
    clipped = ops.clip(x, low, high)
    assert math.isnan(clipped) if math.isnan(x) else clipped == min(max(x, low), high)


@given(x=finite)
def test_floor(x: float) -> None:
    assert ops.floor(x) == math.floor(x)


@given(x=st.floats(-2e8, 2e8, exclude_min=True, exclude_max=True))
def test_sine_and_cosine_are_right_to_2e_16(x: float) -> None:
    with mpmath.workdps(60):
        assert abs(ops.sin(x) - mpmath.sin(mpmath.mpf(x))) <= 2e-16
        assert abs(ops.cos(x) - mpmath.cos(mpmath.mpf(x))) <= 2e-16


@given(x=st.floats(-0.5, 0.5))
def test_the_sine_of_a_small_angle_is_right_to_an_ulp(x: float) -> None:
    with mpmath.workdps(60):
        exact = mpmath.sin(mpmath.mpf(x))
        assert abs(ops.sin(x) - exact) <= ULP * abs(exact) + 2.0**-1074


@given(x=anything)
@example(x=0.5602339676487629)
@example(x=5e-324)
@example(x=math.inf)
def test_tanh_is_right_to_5e_16(x: float) -> None:
    if math.isnan(x):
        assert math.isnan(ops.tanh(x))
        return
    with mpmath.workdps(400):
        exact = mpmath.tanh(mpmath.mpf(x))
        assert abs(ops.tanh(x) - exact) <= 5e-16 * abs(exact)


@given(x=st.floats(0.0, allow_infinity=False))
def test_square_root_is_right_to_half_an_ulp(x: float) -> None:
    with mpmath.workdps(60):
        exact = mpmath.sqrt(mpmath.mpf(x))
        assert abs(ops.sqrt(x) - exact) <= 0.5 * ULP * exact


@given(x=st.floats(0.0, exclude_min=True, allow_infinity=False), exponent=st.floats(-50.0, 50.0))
@example(x=5e-324, exponent=5 / 7)
@example(x=1.7976931348623157e308, exponent=1.0)
@example(x=2.0289288897585773e-308, exponent=-1.0)
def test_power_is_as_right_as_it_says_over_all_positive_numbers(x: float, exponent: float) -> None:
    with mpmath.workdps(60):
        exact = mpmath.power(mpmath.mpf(max(x, LEAST_NORMAL)), mpmath.mpf(exponent))
        got = ops.power(x, exponent)
        if exact >= mpmath.mpf(2) ** 1024:
            assert got == math.inf
        elif exact < LEAST_NORMAL:
            assert abs(got - exact) <= 2.0**-1073
        else:
            assert abs(got - exact) <= 3e-16 * (1.0 + abs(exponent)) * exact


@given(x=st.floats(max_value=-0.0, exclude_max=True))
def test_roots_of_negative_numbers_are_nan(x: float) -> None:
    assume(x < 0.0)
    assert math.isnan(ops.sqrt(x))
    assert math.isnan(ops.power(x, 5 / 7))


@pytest.mark.parametrize("x", [math.inf, -math.inf, 2e8, -1e300])
def test_sine_and_cosine_beyond_their_range_are_nan(x: float) -> None:
    assert math.isnan(ops.sin(x))
    assert math.isnan(ops.cos(x))


@pytest.mark.parametrize(
    ("x", "exponent", "value"),
    [
        (0.0, 5 / 7, 0.0),
        (-0.0, 5 / 7, 0.0),
        (0.0, 0.0, 1.0),
        (0.0, -1.0, math.inf),
        (math.inf, 0.5, math.inf),
        (math.inf, -0.5, 0.0),
        (math.inf, 0.0, 1.0),
        (1.0, 1e300, 1.0),
        (2.0, 1e300, math.inf),
        (0.5, 1e300, 0.0),
        (1e200, 2.0, math.inf),
        (1e-200, 2.0, 0.0),
        (4.0, math.inf, math.inf),
        (0.25, math.inf, 0.0),
        (1.0, math.inf, 1.0),
        (1.0 - 2.0**-53, -math.inf, math.inf),
        (4.0, math.nan, math.nan),
        (math.nan, 1.0, math.nan),
        (-8.0, 1 / 3, math.nan),
        (-math.inf, 2.0, math.nan),
    ],
)
def test_power_at_the_ends(x: float, exponent: float, value: float) -> None:
    assert same(ops.power(x, exponent), value)
    assert same(compiled_op("power")(x, exponent), value)


@given(x=st.floats(-(2.0**50), 2.0**50))
def test_nearest_rounds_half_to_even(x: float) -> None:
    assert ops.nearest(x) == round(x)


@given(x=finite, exponent=st.floats(0.01, 1.0))
def test_signed_power_is_odd_and_undone_by_its_reciprocal(x: float, exponent: float) -> None:
    assert same(ops.signed_power(-x, exponent), -ops.signed_power(x, exponent))
    if 1e-2 < abs(x) < 1e2:
        back = ops.signed_power(ops.signed_power(x, exponent), 1.0 / exponent)
        assert back == pytest.approx(x, rel=2e-16 * (2.0 + 1.0 / exponent) * 4.0)


@given(
    half=st.integers(1, 10**6),
    samples=st.integers(0, 10**7),
    dt=st.floats(1e-6, 1.0),
)
@example(half=200_000, samples=600_000, dt=1e-5)
def test_square_wave_switches_on_the_sample(half: int, samples: int, dt: float) -> None:
    """Half a period of whole samples: the sign follows from counting them."""
    expected = 1.0 if (samples // half) % 2 == 0 else -1.0
    assert ops.square_wave(samples * dt, 2 * half * dt) == expected


@given(t=st.floats(0.0, 1e6), period=st.floats(1e-3, 1e3))
def test_square_wave_is_plus_or_minus_one(t: float, period: float) -> None:
    assert abs(ops.square_wave(t, period)) == 1.0
