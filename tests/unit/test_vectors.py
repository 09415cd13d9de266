"""Vectors and matrices: their arithmetic is numpy's, and the same interpreted and compiled."""

import inspect
import pickle
from typing import get_type_hints

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.core.block import field_at, leaves
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.vectors import matrix, vector
from hydroservo.engine.compiling import compiled_function

Three = vector("Three", 3, Field("m/s", "speed of wheel", at_least=0))
Second = vector("Second", 1000, Field("V", "command"))
Two = vector("Two", 2, Field("N", "force"))
Table = matrix("Table", Three, Two)

numbers = st.floats(-1e6, 1e6)
threes = st.builds(Three, numbers, numbers, numbers)


@given(threes, threes, numbers)
def test_each_method_is_what_numpy_gives(a, b, factor: float) -> None:
    x, y = np.array(a), np.array(b)
    assert a.plus(b) == Three(*(x + y).tolist())
    assert a.minus(b) == Three(*(x - y).tolist())
    assert a.times(b) == Three(*(x * y).tolist())
    assert a.scaled(factor) == Three(*(factor * x).tolist())
    assert a.filled(factor) == Three(factor, factor, factor)
    assert a.with_first(factor) == Three(factor, *a[1:])
    assert a.shifted(factor) == Three(factor, a.e1, a.e2)
    assert a.differences() == Three(*np.diff(x, prepend=0.0).tolist())
    assert a.differences_transposed() == Three(*(-np.diff(x, append=0.0)).tolist())
    low, high = Three(*np.minimum(x, y).tolist()), Three(*np.maximum(x, y).tolist())
    assert a.filled(factor).clipped(low, high) == Three(*np.clip(factor, low, high).tolist())
    assert a.dot(b) == pytest.approx(x @ y, rel=1e-12, abs=1e-3)
    assert a.total() == pytest.approx(x.sum(), rel=1e-12, abs=1e-6)


@given(threes, threes)
def test_one_is_the_transpose_of_the_other(a, b) -> None:
    assert a.differences().dot(b) == pytest.approx(a.dot(b.differences_transposed()), rel=1e-9, abs=1e-2)


def test_a_matrix_times_a_vector() -> None:
    rows = np.array([[1.0, 2.0, 3.0], [-4.0, 5.0, 0.5]])
    table = Table(*(Three(*row) for row in rows.tolist()))
    assert table.times(Three(1.0, 10.0, 100.0)) == Two(*(rows @ [1.0, 10.0, 100.0]).tolist())


def test_each_entry_is_declared_with_its_number() -> None:
    assert declared_fields(Three)["e2"] == Field("m/s", "speed of wheel 2", at_least=0)
    assert get_type_hints(Table)["r1"] is Three
    table = Table(Three(1.0, 2.0, 3.0), Three(4.0, 5.0, 6.0))
    assert dict(leaves(table))["r2.e3"] == 6.0
    assert field_at(table, "r2.e3").meaning == "speed of wheel 3"


def test_the_text_of_a_method_can_be_read() -> None:
    assert "self.e1 * other.e1 + self.e2 * other.e2" in inspect.getsource(Two.dot)


def test_a_second_at_1_khz_is_summed_from_left_to_right_interpreted_and_compiled() -> None:
    rng = np.random.default_rng(1)
    a, b = (Second(*rng.normal(size=1000).tolist()) for _ in range(2))
    total = dot = 0.0
    for x, y in zip(a, b, strict=True):
        total, dot = total + x, dot + x * y
    assert a.total() == compiled_function(Second.total)(a) == total
    assert a.dot(b) == compiled_function(Second.dot)(a, b) == dot


def test_a_vector_is_pickled() -> None:
    copy = pickle.loads(pickle.dumps(Three(1.0, 2.0, 3.0)))
    assert copy == Three(1.0, 2.0, 3.0)
