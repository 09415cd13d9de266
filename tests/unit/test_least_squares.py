"""Many small searches side by side: where they end, and that none changes a bit of another."""

import numpy as np
import pytest

from hydroservo.runs.steady import Iterate, Numbers, Which, least_squares

CURVES = np.random.default_rng(3).uniform(1.0, 100.0, 40)


def valleys(x: Numbers, which: Which) -> Numbers:
    """Rosenbrock's valley, one of each curvature, with its least cost of 0 at (1, 1)."""
    return np.stack([CURVES[which] * (x[1] - x[0] * x[0]), 1.0 - x[0]])


def searched(which: Which) -> Iterate:
    return least_squares(lambda x, some: valleys(x, which[some]), 2, len(which), 1e-12)


def test_each_search_ends_at_the_bottom() -> None:
    found = searched(np.arange(40))
    assert np.abs(found.x - 1.0).max() < 1e-12
    assert np.abs(found.residuals).max() < 1e-12


def test_no_search_changes_a_bit_of_another() -> None:
    together = searched(np.arange(40)).x
    for some in (np.array([7]), np.arange(20, 40), np.arange(39, -1, -3)):
        assert np.array_equal(searched(some).x, together[:, some])


def test_a_line_is_fitted_as_its_normal_equations_say() -> None:
    t, y = np.arange(5.0), np.array([1.0, 3.0, 2.0, 5.0, 4.0])
    found = least_squares(lambda x, _: x[0] + x[1] * t[:, None, None] - y[:, None, None], 2, 1, 1e-12)
    assert found.x[:, 0] == pytest.approx([1.4, 0.8], rel=1e-6)  # slopes from differences are good to 2^-22


def test_a_number_that_moves_nothing_stays_and_what_is_not_finite_is_left() -> None:
    def residuals(x: Numbers, _: Which) -> Numbers:
        return np.where(x[0] > 2.0, np.nan, np.exp(x[0]) - 5.0)[np.newaxis]

    found = least_squares(residuals, 2, 1, 1e-12)
    assert found.x[:, 0] == pytest.approx([np.log(5.0), 0.0], rel=1e-14)
