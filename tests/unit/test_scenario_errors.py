"""Errors a user can mend: one line, whole again after a trip through a worker process."""

import pickle

import pytest

from hydroservo import HydroservoError, LoopError, ParameterError, ScenarioError


@pytest.mark.parametrize(
    "error",
    [
        ParameterError("plant.mass", -1.0, "must be a finite number above 0 [kg]"),
        ScenarioError("my.toml", "plant.mass", "is missing"),
        LoopError("does not fit"),
    ],
)
def test_pickled(error: HydroservoError) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)


@pytest.mark.parametrize(
    "error",
    [
        ParameterError("a\nb", "two\nlines", "x\x1b[31m"),
        ParameterError("seed", 10**5000, "must be a whole number"),
        ScenarioError("\ud800", "k\r", "p\u2028q"),
        ScenarioError("f" * 10**6, "k" * 10**6, "p" * 10**6),
        LoopError("a\nb"),
    ],
)
def test_one_line(error: HydroservoError) -> None:
    assert str(error).isprintable()
    assert len(str(error)) < 1900
