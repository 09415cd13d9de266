import numpy as np
import pytest

from hydroservo.errors import ParameterError
from hydroservo.identification.friction_map import FrictionMap, friction_map

SPEEDS = np.array([0.01, 0.1, 0.5])
TRUE = FrictionMap(
    SPEEDS, np.array([200.0, 300.0, 900.0]), np.array([150.0, 180.0, 700.0]), np.array([3.0, -2.0])
)


def test_a_map_is_found_beside_what_else_is_in_the_force():
    rng = np.random.default_rng(0)
    velocity = rng.uniform(-0.6, 0.6, 3000)
    besides = rng.uniform(50.0, 90.0, (3000, 2))
    force = TRUE.at(velocity) + besides @ TRUE.besides + rng.normal(scale=5.0, size=3000)
    found = friction_map(velocity, force, SPEEDS, besides)
    for name in ("forwards", "backwards"):
        np.testing.assert_allclose(getattr(found, name), getattr(TRUE, name), atol=4.0)
    np.testing.assert_allclose(found.besides, TRUE.besides, atol=4.0)


def test_friction_is_against_motion_and_held_beyond_the_ends():
    np.testing.assert_array_equal(TRUE.at([2.0, -2.0, 0.001]), [900.0, -700.0, 200.0])


@pytest.mark.parametrize(
    ("velocity", "force", "speeds", "said"),
    [
        (np.ones(9), np.ones(8), SPEEDS, "as many samples as the velocity"),
        (np.ones(9), np.ones(9), [0.1, 0.1], "must be more than 0 and increase"),
        (np.zeros(9), np.ones(9), SPEEDS, "at least 6 samples that move"),
    ],
)
def test_what_makes_no_map_is_refused(velocity, force, speeds, said):
    with pytest.raises(ParameterError, match=said):
        friction_map(velocity, force, speeds)


def test_a_constant_is_not_told_from_friction():
    velocity = np.random.default_rng(1).uniform(-0.6, 0.6, 300)
    with pytest.raises(ParameterError, match="as a constant does"):
        friction_map(velocity, TRUE.at(velocity), SPEEDS, np.ones((300, 1)))
