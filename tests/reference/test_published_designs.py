"""Designs against what SLICOT documents of its own: examples/data and examples/results of SLICOT-Reference.

Its results have four decimals, and its controllers are for positive feedback, u = K y.
"""

import math

import numpy as np
import pytest

from hydroservo.control.synthesis.coprime import StateMatrices, robust_controller
from hydroservo.control.synthesis.loop_shaping import to_bilinear
from hydroservo.control.synthesis.riccati import solution
from hydroservo.control.synthesis.sampled import under_held_input

INTEGRATORS, PUSH = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([0.0, 1.0])

# SB10ID, with a factor of 1: the plant, and the controller of reduced order that is best
SHAPED = StateMatrices(
    np.array(
        [
            [-1.0, 0.0, 4.0, 5.0, -3.0, -2.0],
            [-2.0, 4.0, -7.0, -2.0, 0.0, 3.0],
            [-6.0, 9.0, -5.0, 0.0, 2.0, -1.0],
            [-8.0, 4.0, 7.0, -1.0, -3.0, 0.0],
            [2.0, 5.0, 8.0, -9.0, 1.0, -4.0],
            [3.0, -5.0, 8.0, 0.0, 2.0, -6.0],
        ]
    ),
    np.array([[-3.0, -4.0], [2.0, 0.0], [-5.0, -7.0], [4.0, -6.0], [-3.0, 9.0], [1.0, -2.0]]),
    np.array(
        [
            [1.0, -1.0, 2.0, -4.0, 0.0, -3.0],
            [-3.0, 0.0, 5.0, -1.0, 1.0, 1.0],
            [-7.0, 5.0, 0.0, -8.0, 2.0, -2.0],
        ]
    ),
    np.array([[1.0, -2.0], [0.0, 4.0], [5.0, -3.0]]),
)
BEST = StateMatrices(
    np.array(
        [
            [-39.0671, 9.9293, 22.2322, -27.4113, 43.8655],
            [-6.6117, 3.0006, 11.0878, -11.4130, 15.4269],
            [33.6805, -6.6934, -23.9953, 14.1438, -33.4358],
            [-32.3191, 9.7316, 25.4033, -24.0473, 42.0517],
            [-44.1655, 18.7767, 34.8873, -42.4369, 50.8437],
        ]
    ),
    np.array(
        [
            [-10.2905, -16.5382, -10.9782],
            [-4.3598, -8.7525, -5.1447],
            [6.5962, 1.8975, 6.2316],
            [-9.8770, -14.7041, -11.8778],
            [-9.6726, -22.7309, -18.2692],
        ]
    ),
    np.array([[-0.6647, -0.0599, -1.0376, 0.5619, 1.7297], [-8.4202, 3.9573, 7.3094, -7.6283, 10.6768]]),
    np.array([[0.8466, 0.4979, -0.6993], [-1.2226, -4.8689, -4.5056]]),
)

# SB10KD, sampled, with a factor of 1.1
SAMPLED = StateMatrices(
    np.array(
        [
            [0.2, 0.0, 0.3, 0.0, -0.3, -0.1],
            [-0.3, 0.2, -0.4, -0.3, 0.0, 0.0],
            [-0.1, 0.1, -0.1, 0.0, 0.0, -0.3],
            [0.1, 0.0, 0.0, -0.1, -0.1, 0.0],
            [0.0, 0.3, 0.6, 0.2, 0.1, -0.4],
            [0.2, -0.4, 0.0, 0.0, 0.2, -0.2],
        ]
    ),
    np.array([[-1.0, -2.0], [1.0, 3.0], [-3.0, -4.0], [1.0, -2.0], [0.0, 1.0], [1.0, 5.0]]),
    np.array([[1.0, -1.0, 2.0, -2.0, 0.0, -3.0], [-3.0, 0.0, 1.0, -1.0, 1.0, -1.0]]),
    np.zeros((2, 2)),
)
GOOD = StateMatrices(
    np.array(
        [
            [0.0337, 0.0222, 0.0858, 0.1264, -0.1872, 0.1547],
            [0.4457, 0.0668, -0.2255, -0.3204, -0.4548, -0.0691],
            [-0.2419, -0.2506, -0.0982, -0.1321, -0.0130, -0.0838],
            [-0.4402, 0.3654, -0.0335, -0.2444, 0.6366, -0.6469],
            [-0.3623, 0.3854, 0.4162, 0.4502, 0.0065, 0.1261],
            [-0.0121, -0.4377, 0.0604, 0.2265, -0.3389, 0.4542],
        ]
    ),
    np.array(
        [
            [0.0931, -0.0269],
            [-0.0872, 0.1599],
            [0.0956, -0.1469],
            [-0.1728, 0.0129],
            [0.2022, -0.1154],
            [0.2419, -0.1737],
        ]
    ),
    np.array(
        [
            [-0.3677, 0.2188, 0.0403, -0.0854, 0.3564, -0.3535],
            [0.1624, -0.0708, 0.0058, 0.0606, -0.2163, 0.1802],
        ]
    ),
    np.array([[-0.0857, -0.0246], [0.0460, 0.0074]]),
)


def response(law: StateMatrices, z: complex) -> np.ndarray:
    return law.c @ np.linalg.solve(z * np.eye(len(law.a)) - law.a, law.b) + law.d


def closed_norm(plant: StateMatrices, law: StateMatrices, points: np.ndarray) -> float:
    """The largest singular value of [K; 1] (1 - G K)^-1 [1, G] at some of s or z."""
    found = []
    for z in points:
        g, k = response(plant, z), response(law, z)
        one = np.eye(len(g))
        whole = np.vstack([k, one]) @ np.linalg.solve(one - g @ k, np.hstack([one, g]))
        found.append(np.linalg.svd(whole, compute_uv=False)[0])
    return max(found)


def test_a_sampled_riccati_equation_without_a_price() -> None:
    """SB02ND: X and F."""
    moved, driven = np.array([[2.0, -1.0], [1.0, 0.0]]), np.array([[1.0], [0.0]])
    x = solution(moved, driven, np.diag([0.0, 1.0]), np.zeros((1, 1)))
    assert x == pytest.approx(np.eye(2), abs=1e-12)
    gain = np.linalg.solve(driven.T @ x @ driven, driven.T @ x @ moved)
    assert gain == pytest.approx(np.array([[2.0, -1.0]]), abs=1e-12)


@pytest.mark.parametrize(
    ("weights", "published"),
    [
        ((1.0, 1.0), [[1.7321, 1.0], [1.0, 1.7321]]),  # SB02OD
        ((1.0, 2.0), [[2.0, 1.0], [1.0, 2.0]]),  # SB02MD
    ],
)
def test_fast_sampling_leads_to_riccati_equations_in_continuous_time(
    weights: tuple[float, float], published: list[list[float]]
) -> None:
    """With Q h and R h; X is off by the order of h, and 2 X(h/2) - X(h) by that of its square."""

    def at(h: float) -> np.ndarray:
        moved, driven = under_held_input(INTEGRATORS, PUSH, h)
        return solution(moved, driven[:, np.newaxis], h * np.diag(weights), np.array([[h]]))

    assert 2.0 * at(5e-4) - at(1e-3) == pytest.approx(np.array(published), abs=6e-5)


def test_a_scalar_riccati_equation_has_the_golden_ratio() -> None:
    """X = X - X^2/(X + 1) + 1."""
    one = np.ones((1, 1))
    assert solution(one, one, one, one).item() == pytest.approx(0.5 + math.sqrt(1.25), rel=1e-15)


def test_the_best_robust_controller_is_the_published_one() -> None:
    """SB10ID has it of one state less, to which ours tends."""
    found = robust_controller(SHAPED, 1.0 + 1e-8)
    for w in (0.0, 0.1, 1.0, 10.0, 100.0):
        theirs = response(BEST, 1j * w)
        assert np.abs(response(found.k, 1j * w) + theirs).max() < 1e-4 * np.abs(theirs).max()
    norm = closed_norm(SHAPED, BEST, 1j * np.geomspace(1e-4, 1e6, 2000))
    assert norm == pytest.approx(found.least_gamma, rel=1e-4)


def test_a_published_sampled_controller_keeps_within_what_is_promised() -> None:
    """SB10KD: between the least gamma that there is and 1.1 of it, by the bilinear plant that ours is of."""
    found = robust_controller(to_bilinear(SAMPLED), 1.1)
    norm = closed_norm(SAMPLED, GOOD, np.exp(1j * np.linspace(0.0, math.pi, 2000)))
    assert found.least_gamma < norm < found.gamma
