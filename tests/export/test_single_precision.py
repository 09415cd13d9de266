"""The elementary functions in single precision, against NumPy's in double."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part, Precision
from tests.support.export.small_laws import NAMED, law
from tests.support.needs import needs
from tools.targets.host import library

EPS = 2.0**-23
ROWS = 20_000


def computed(
    folder: Path, expression: str, x: NDArray[np.float32], z: NDArray[np.float32]
) -> NDArray[np.float64]:
    """An expression of y.velocity and r.value in single precision, as C computes it."""
    needs("gcc")
    loop = law(folder, f"return LawState({expression}, y.velocity + r.value)")
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED, precision=Precision.SINGLE)
    states = library(unit, folder).run(np.column_stack([x, z]))
    return np.asarray(states[:, 0], np.float64)


def drawn(low: float, high: float, seed: int) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(low, high, ROWS).astype(np.float32)


@pytest.mark.parametrize("function", ["sin", "cos"])
@pytest.mark.parametrize("largest", [3.0, 8000.0])
def test_circular_functions(function: str, largest: float, tmp_path: Path) -> None:
    x = drawn(-largest, largest, 1)
    found = computed(tmp_path, f"ops.{function}(y.velocity)", x, x)
    np.testing.assert_allclose(found, getattr(np, function)(x.astype(np.float64)), rtol=0.0, atol=1.5 * EPS)


def test_the_hyperbolic_tangent(tmp_path: Path) -> None:
    x = drawn(-12.0, 12.0, 2) * 10.0 ** drawn(-6.0, 0.0, 3)
    found = computed(tmp_path, "ops.tanh(y.velocity)", x, x)
    np.testing.assert_allclose(found, np.tanh(x.astype(np.float64)), rtol=3.0 * EPS, atol=0.0)


def test_powers(tmp_path: Path) -> None:
    x, z = 10.0 ** drawn(-15.0, 15.0, 4), drawn(-2.0, 2.0, 5)
    found = computed(tmp_path, "ops.power(y.velocity, r.value)", x, z)
    expected = x.astype(np.float64) ** z.astype(np.float64)
    np.testing.assert_allclose(found, expected, rtol=1.5 * EPS * (1.0 + 2.0), atol=0.0)


def test_roundings(tmp_path: Path) -> None:
    x = np.concatenate([drawn(-20.0, 20.0, 6), drawn(-3e7, 3e7, 7), np.arange(-4.0, 4.5, 0.5, np.float32)])
    x = x.astype(np.float32)
    assert np.array_equal(computed(tmp_path, "ops.floor(y.velocity)", x, x), np.floor(x.astype(np.float64)))
