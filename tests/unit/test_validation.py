"""Parameters on their way to compiled code: made floats, and refused in one line."""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from hydroservo.core.block import Block, Field
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.time_series import TimeSeries
from hydroservo.core.validation import allowed, checked


class Inner(NamedTuple):
    share: Annotated[float, Field("", "share", "this test", above=0, below=1)] = 0.5


class Sample(NamedTuple):
    mass: Annotated[float, Field("kg", "mass", "this test", above=0)] = 1.0
    count: Annotated[int, Field("", "count", "this test", at_least=1, at_most=9)] = 2
    flag: bool = False
    plain: float = 0.0
    big: int = 0
    table: NDArray[np.float64] = np.zeros(2)
    inner: Block = Inner()
    series: TimeSeries = TimeSeries()


def test_numbers_become_what_they_are_declared_to_be() -> None:
    block = checked(Sample(mass=np.float32(2.0), count=np.int64(3), flag=np.bool_(True), plain=4))
    kinds = [type(value) for value in block[:4]]
    assert kinds == [float, int, bool, float]
    assert block[:4] == (2.0, 3, True, 4.0)


def test_arrays_become_contiguous_and_of_64_bits() -> None:
    knots, coefficients = np.arange(4, dtype=np.int32)[::2], np.zeros((1, 4), np.float32).T
    series = checked(Sample(series=TimeSeries(knots, coefficients))).series
    for array in series:
        assert array.dtype == np.float64
        assert array.flags.c_contiguous


@pytest.mark.parametrize(
    ("knots", "coefficients"),
    [
        (np.zeros(0), np.zeros((4, 0))),
        (np.zeros(1), np.zeros((4, 0))),
        (np.arange(3.0), np.zeros((4, 1))),
        (np.arange(2.0), np.zeros((3, 1))),
        (np.arange(2.0), np.zeros(4)),
        (np.arange(4.0).reshape(2, 2), np.zeros((4, 3))),
        (np.array([0.0, 0.0]), np.zeros((4, 1))),
        (np.array([1.0, 0.0]), np.zeros((4, 1))),
        (np.array([0.0, math.nan]), np.zeros((4, 1))),
        (np.array([0.0, math.inf]), np.zeros((4, 1))),
        (np.array([0.0, 1.0]), np.full((4, 1), math.nan)),
    ],
)
def test_arrays_that_are_no_record(knots: Any, coefficients: Any) -> None:
    with pytest.raises(ParameterError, match=r"^series.*must come from Curve.from_samples"):
        checked(Sample(series=TimeSeries(knots, coefficients)))


def test_defaults_pass_unchanged() -> None:
    assert checked(Sample())[:5] == Sample()[:5]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"mass": 0.0}, "mass = 0.0: must be a finite number above 0 [kg]"),
        ({"mass": math.nan}, "mass = nan: must be a finite number above 0 [kg]"),
        ({"mass": math.inf}, "mass = inf: must be a finite number above 0 [kg]"),
        ({"mass": "heavy"}, "mass = 'heavy': must be a finite number above 0 [kg]"),
        ({"mass": None}, "mass = None: must be a finite number above 0 [kg]"),
        ({"mass": True}, "mass = True: must be a finite number above 0 [kg]"),
        ({"mass": 1j}, "mass = 1j: must be a finite number above 0 [kg]"),
        ({"count": 2.0}, "count = 2.0: must be a whole number at least 1 and at most 9"),
        ({"big": 2**53 + 1}, "big = 9007199254740993: must be a whole number between -2^53 and 2^53"),
        ({"big": -(2**60)}, "big = -1152921504606846976: must be a whole number between -2^53 and 2^53"),
        ({"plain": np.zeros(2)}, "plain = 'an array of shape (2,)': must be a single number"),
        ({"table": 1.0}, "table = 'float': must be an array of real numbers"),
        ({"table": [1.0]}, "table = 'list': must be an array of real numbers"),
        ({"table": np.array(["a"])}, "table = '<U1': must be an array of real numbers"),
        ({"table": np.zeros(1, complex)}, "table = 'complex128': must be an array of real numbers"),
        ({"count": 10}, "count = 10: must be a whole number at least 1 and at most 9"),
        ({"flag": 1}, "flag = 1: must be true or false"),
        ({"plain": -math.inf}, "plain = -inf: must be a finite number"),
        ({"inner": Inner(1.0)}, "inner.share = 1.0: must be a finite number above 0 and below 1"),
    ],
)
def test_what_a_parameter_may_not_be(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ParameterError) as error:
        checked(Sample()._replace(**changes))
    assert str(error.value) == says


def test_the_error_carries_its_parts() -> None:
    with pytest.raises(HydroservoError) as error:
        checked(Sample(inner=Inner(-1.0)), "controller")
    assert isinstance(error.value, ParameterError)
    assert error.value.path == "controller.inner.share"
    assert error.value.value == -1.0
    assert error.value.allowed == "must be a finite number above 0 and below 1"


def test_a_long_value_does_not_break_the_line() -> None:
    with pytest.raises(ParameterError) as error:
        checked(Sample(mass="heavy\n" * 1000))
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 200


def test_allowed_says_bounds_and_unit() -> None:
    assert allowed(Field("m", "length", at_least=0, below=2)) == "a finite number at least 0 and below 2 [m]"
    assert allowed(Field("", "seed", at_least=0), whole=True) == "a whole number at least 0"
    assert allowed(Field("", "number")) == "a finite number"
