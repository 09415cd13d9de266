"""The functions of ops without bits of numbers, compiled, against the C library's."""

import math
from collections.abc import Callable
from random import Random

import numpy as np
import pytest

from hydroservo.core.ops import basic, binary, portable
from hydroservo.engine.compiling import compiled_function
from hydroservo.testing.case import bits

DRAW = Random(1)
EDGES = [
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    2.0**-1022,
    1.0,
    -1.0,
    2.0**52,
    2.0**53 + 2.0,
    1.7e308,
    math.inf,
    -math.inf,
]
DRAWN = [
    DRAW.choice((-1, 1)) * DRAW.uniform(1.0, 2.0) * 2.0 ** DRAW.randint(-1070, 1023) for _ in range(3000)
]
NUMBERS = [*EDGES, math.nan, *(0.5 * k for k in range(-9, 10)), *DRAWN]
NORMAL = [x for x in NUMBERS if 2.0**-1022 <= x < math.inf]


@pytest.mark.parametrize("pair", [(portable.absolute, math.fabs), (portable.floor, basic.floor)])
def test_of_one_number(pair: tuple[Callable[[float], float], Callable[[float], float]]) -> None:
    function = compiled_function(pair[0])
    assert [x for x in NUMBERS if bits(function(x)) != bits(pair[1](x))] == []


def test_the_sign_is_that_of_a_zero_too() -> None:
    function = compiled_function(portable.copysign)
    pairs = [(x, y) for x in (1.5, -2.0, 0.0, math.inf) for y in NUMBERS if not math.isnan(y)]
    assert [pair for pair in pairs if bits(function(*pair)) != bits(math.copysign(*pair))] == []


@pytest.mark.parametrize("name", ["exponent", "mantissa"])
def test_the_parts_of_a_number(name: str) -> None:
    function = compiled_function(getattr(portable, name))
    assert [x for x in NORMAL if function(x) != getattr(binary, name)(x)] == []


def test_scaling_rounds_once() -> None:
    function = compiled_function(portable.scaled)
    pairs = [(DRAW.uniform(0.5, 2.0), float(n)) for n in range(-2000, 2001)]
    assert [pair for pair in pairs if bits(function(*pair)) != bits(binary.scaled(*pair))] == []
    assert math.isnan(function(1.0, math.nan))
    assert math.isnan(function(1.0, 1e9))


def test_a_remainder_is_exact() -> None:
    function = compiled_function(portable.remainder)
    pairs = [*zip(NUMBERS, np.random.default_rng(2).permutation(NUMBERS).tolist(), strict=True)]
    pairs += [(a, b) for a in EDGES for b in EDGES]
    assert [pair for pair in pairs if bits(function(*pair)) != bits(fmod(*pair))] == []


def fmod(a: float, b: float) -> float:
    """C's, which gives not-a-number where Python raises."""
    return math.fmod(a, b) if math.isfinite(a) and b != 0.0 else math.nan
