"""Robust stabilisation: a published example, the norm that it promises, and what it does not depend on."""

import math

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov
from scipy.signal import tf2ss

from hydroservo.control.synthesis.coprime import RobustController, StateMatrices, robust_controller


def published() -> StateMatrices:
    """G W of Skogestad, Postlethwaite, Multivariable Feedback Control, 2005, ex. 9.3."""
    slow = np.polymul([10.0, 1.0], np.polymul([0.05, 1.0], [0.05, 1.0]))
    return StateMatrices(*tf2ss([200.0, 400.0], np.polymul(slow, [1.0, 1e-6])))


def random(seed: int, states: int = 5, inputs: int = 2, outputs: int = 3) -> StateMatrices:
    draw = np.random.default_rng(seed).normal
    return StateMatrices(
        draw(size=(states, states)),
        draw(size=(states, inputs)),
        draw(size=(outputs, states)),
        draw(size=(outputs, inputs)),
    )


def response(law: StateMatrices, w: float) -> np.ndarray:
    return law.c @ np.linalg.solve(1j * w * np.eye(len(law.a)) - law.a, law.b) + law.d


def closed_norm(plant: StateMatrices, k: StateMatrices) -> float:
    """max over the frequency of the largest singular value of [K; 1] (1 + G K)^-1 [1, G]."""
    found = []
    for w in np.geomspace(1e-4, 1e5, 3000):
        g, n = response(plant, w), -response(k, w)
        one = np.eye(len(g))
        whole = np.vstack([n, one]) @ np.linalg.solve(one - g @ n, np.hstack([one, g]))
        found.append(np.linalg.svd(whole, compute_uv=False)[0])
    return max(found)


def closed_poles(plant: StateMatrices, found: RobustController) -> np.ndarray:
    k = found.k
    inner = np.linalg.inv(np.eye(len(k.d)) + k.d @ plant.d)
    outer = np.linalg.inv(np.eye(len(plant.d)) + plant.d @ k.d)
    rows = [
        [plant.a - plant.b @ inner @ k.d @ plant.c, -plant.b @ inner @ k.c],
        [k.b @ outer @ plant.c, k.a - k.b @ outer @ plant.d @ k.c],
    ]
    return np.linalg.eigvals(np.block(rows))


def test_the_published_example() -> None:
    assert robust_controller(published()).least_gamma == pytest.approx(2.34, abs=0.005)
    assert robust_controller(published()).least_gamma == pytest.approx(2.33877, abs=1e-5)


@pytest.mark.parametrize("plant", [published(), random(1), random(2), random(3, 4, 1, 1)])
def test_the_closed_loop_has_the_norm_that_is_promised(plant: StateMatrices) -> None:
    found = robust_controller(plant, 1.1)
    norm = closed_norm(plant, found.k)
    assert norm <= found.gamma * (1.0 + 1e-9)
    assert norm == pytest.approx(found.gamma, rel=0.02)
    best = robust_controller(plant, 1.0001)
    assert closed_norm(plant, best.k) == pytest.approx(best.least_gamma, rel=1e-3)


@pytest.mark.parametrize("seed", range(5))
def test_the_closed_loop_is_stable_where_the_plant_is_not(seed: int) -> None:
    plant = random(seed)
    assert np.linalg.eigvals(plant.a).real.max() > 0.0
    assert closed_poles(plant, robust_controller(plant)).real.max() < 0.0


def test_the_least_gamma_is_that_of_the_hankel_norm() -> None:
    """gamma_min = (1 - ||[M N]||_H^2)^(-1/2), of the normalised left factors from one Riccati equation."""
    plant = random(4)._replace(d=np.zeros((3, 2)))
    a, b, c, _ = plant
    z = solve_continuous_are(a.T, c.T, b @ b.T, np.eye(3))
    heard = -z @ c.T
    free, driven = a + heard @ c, np.hstack([b, heard])
    reach = solve_continuous_lyapunov(free, -driven @ driven.T)
    seen = solve_continuous_lyapunov(free.T, -c.T @ c)
    hankel = math.sqrt(np.abs(np.linalg.eigvals(reach @ seen)).max())
    assert robust_controller(plant).least_gamma == pytest.approx(1.0 / math.sqrt(1.0 - hankel**2), rel=1e-10)


def test_neither_units_of_states_nor_of_time_matter() -> None:
    plant = published()
    sizes = 10.0 ** np.array([6.0, -5.0, 3.0, -8.0])
    units = StateMatrices(
        plant.a * sizes[:, np.newaxis] / sizes, plant.b * sizes[:, np.newaxis], plant.c / sizes, plant.d
    )
    faster = StateMatrices(1e6 * plant.a, 1e3 * plant.b, 1e3 * plant.c, plant.d)
    here = robust_controller(plant)
    for other, rate in ((units, 1.0), (faster, 1e6)):
        there = robust_controller(other)
        assert there.gamma == pytest.approx(here.gamma, rel=1e-10)
        for w in (0.1, 3.0, 100.0):
            assert response(there.k, rate * w) == pytest.approx(response(here.k, w), rel=1e-7)


def test_what_cannot_be_stabilised_is_refused() -> None:
    hidden = StateMatrices(
        np.diag([1.0, -1.0]), np.array([[0.0], [1.0]]), np.array([[1.0, 1.0]]), np.zeros((1, 1))
    )
    with pytest.raises(ValueError, match="a Riccati equation has no solution"):
        robust_controller(hidden)
    with pytest.raises(ValueError, match="beyond the range of floating-point numbers"):
        robust_controller(hidden._replace(b=np.array([[np.inf], [1.0]])))
