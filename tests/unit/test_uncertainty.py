"""Covariances and resampled blocks of a linear model, against what theory says of both."""

import numpy as np
import pytest

from hydroservo.identification.regression import long_run_covariance
from hydroservo.identification.uncertainty import resampled_deviations

SAMPLES, COUNT = 40_000, 100  # in two stretches of as many blocks each
PRIOR = 1e-9 * np.eye(2)


def noise(rho, rng):
    """Noise of variance 1 that hangs together by rho from one sample to the next."""
    found = rng.normal(size=SAMPLES)
    for k in range(1, SAMPLES):
        found[k] = rho * found[k - 1] + np.sqrt(1.0 - rho**2) * found[k]
    return found


def parts(rho):
    """Scores and information of two stretches of y = a + b x + noise, x white."""
    rng = np.random.default_rng(7)
    table = np.stack([np.ones(SAMPLES), rng.normal(size=SAMPLES)], axis=1)
    scores = noise(rho, rng)[:, np.newaxis] * table
    halves = np.split(table, 2)
    bends = [np.array([block.T @ block for block in np.split(half, COUNT)]) for half in halves]
    return np.split(scores, 2), bends


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_resampled_blocks_know_how_sure_a_mean_and_a_slope_are(rho):
    scores, bends = parts(rho)
    found = resampled_deviations(scores, bends, PRIOR, 0) * np.sqrt(SAMPLES)
    assert found[0] == pytest.approx(np.sqrt((1.0 + rho) / (1.0 - rho)), rel=0.15)
    assert found[1] == pytest.approx(1.0, rel=0.15)  # noise times a white signal is white
    np.testing.assert_array_equal(found, resampled_deviations(scores, bends, PRIOR, 0) * np.sqrt(SAMPLES))


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_the_sandwich_and_resampled_blocks_agree(rho):
    scores, bends = parts(rho)
    bread = np.linalg.inv(sum(bend.sum(axis=0) for bend in bends))
    sandwich = np.sqrt(np.diag(bread @ long_run_covariance(scores) @ bread))
    np.testing.assert_allclose(resampled_deviations(scores, bends, PRIOR, 1), sandwich, rtol=0.2)
