import math

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

import hydroservo as hs
from hydroservo.core.block import value_at
from hydroservo.core.errors import ParameterError
from hydroservo.identification.observer import fading_gain
from hydroservo.identification.problem import delay_of, simulate_segments
from tests.support.synthetic_logs import NOISE, SCENARIO, SHORT, exact_log

pytestmark = pytest.mark.slow  # each fits a log

TOLD = ("plant.mass", "plant.bulk_modulus", "valve.time_constant")
RANGES = dict.fromkeys((*TOLD, "plant.damping"), "-40%..+70%")
WRONG = {"plant.mass": 7.0}
BRIEF = SHORT | {"simulation.duration": "1.5 s"}
LOAD = {"load.type": "Sine", "load.amplitude": "300 N", "load.frequency": "0.1 Hz"}
PUSHED = BRIEF | LOAD
NOISY = {"velocity": 5e-3, "hydraulic_force": 50.0}
HORIZON = 0.02
CHANGED = 700  # a sample


def with_noise(exact, noise, seed):
    rng = np.random.default_rng(seed)
    return exact | {
        name: exact[name] + rng.normal(scale=one, size=exact[name].size) for name, one in noise.items()
    }


def relative_errors(found):
    truth = hs.load_scenario(SCENARIO, BRIEF)
    return {path: found.parameters[path].value / value_at(truth, path) - 1.0 for path in TOLD}


def test_a_slow_load_that_no_one_recorded_spoils_a_simulation_and_not_a_prediction():
    log = with_noise(exact_log(PUSHED), NOISE, 0)
    both = [
        relative_errors(hs.identify(SCENARIO, log, RANGES, changes=BRIEF | WRONG, threads=1, horizon=one))
        for one in (None, HORIZON)
    ]
    assert abs(both[0]["plant.bulk_modulus"]) > 0.1
    assert abs(both[0]["plant.mass"]) > 0.03
    for path in TOLD:
        assert abs(both[1][path]) < 0.03, path


@pytest.mark.parametrize("horizon", [5e-3, HORIZON])
def test_a_prediction_under_a_wrong_and_slow_load_tells_what_the_machine_is(horizon):
    log = with_noise(exact_log(SHORT | LOAD), NOISE, 0)
    found = hs.identify(SCENARIO, log, RANGES, changes=SHORT | WRONG, threads=1, horizon=horizon)
    for path, error in relative_errors(found).items():
        assert abs(error) < 0.015, path


def test_noise_spoils_neither_a_simulation_nor_a_prediction():
    log = with_noise(exact_log(BRIEF), NOISY, 0)
    for horizon in (None, HORIZON):
        found = hs.identify(SCENARIO, log, RANGES, changes=BRIEF | WRONG, threads=1, horizon=horizon)
        one = found.parameters["plant.mass"]
        assert one.low < 6.0 < one.high
        assert found.horizon == horizon


@pytest.mark.parametrize("late", [-0.4, 0.0, 0.4])
def test_a_prediction_does_not_know_the_sample_that_it_predicts(late):
    log = with_noise(exact_log(BRIEF), NOISE, 0)
    fitted = hs.identify(
        SCENARIO, log, {"plant.mass": "-40%..+70%"}, changes=BRIEF, threads=1, horizon=5e-3
    ).fitted
    (one,) = fitted.problem.experiments
    other = one.observer.measured.copy()
    other[CHANGED] *= 1.5
    changed = one._replace(observer=one.observer._replace(measured=other))
    x = fitted.best.x.copy()
    x[delay_of(fitted.problem, 0)] = late
    (before,), (after,) = (
        simulate_segments(fitted.problem._replace(experiments=[each]), x, slopes=False)
        for each in (one, changed)
    )
    for name, values in before.values.items():
        np.testing.assert_array_equal(values[: CHANGED + 1], after.values[name][: CHANGED + 1])
        assert np.any(values[CHANGED + 1 :] != after.values[name][CHANGED + 1 :])


@pytest.mark.parametrize(
    ("horizon", "said"), [(1e-3, "two samples"), (0.0, "horizon"), (math.nan, "horizon")]
)
def test_a_horizon_is_some_samples(horizon, said):
    log = with_noise(exact_log(BRIEF), NOISE, 0)
    with pytest.raises(ParameterError, match=said):
        hs.identify(SCENARIO, log, {"plant.mass": "-40%..+70%"}, changes=BRIEF, threads=1, horizon=horizon)


def test_the_gain_that_forgets_is_that_of_the_riccati_equation():
    transition = np.array([[1.0, 0.01, 0.0], [-0.1, 0.995, 0.02], [0.0, 0.0, 1.0]])
    seen = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    noise, forgetting = np.array([0.1, 0.3]), math.exp(0.02)
    found = fading_gain(transition, seen, noise, forgetting)
    faster = forgetting * transition
    spread = solve_discrete_are(faster.T, seen.T, np.zeros((3, 3)), np.diag(noise**2))
    gain = transition @ spread @ seen.T @ np.linalg.inv(seen @ spread @ seen.T + np.diag(noise**2))
    np.testing.assert_allclose(found, gain, rtol=1e-3, atol=1e-6)
    assert np.abs(np.linalg.eigvals(transition - found @ seen)).max() < 1.0 / forgetting


def test_the_gain_leaves_what_no_signal_shows():
    transition = np.array([[0.9, 0.0], [0.0, 1.0]])  # the second one by itself, and unseen
    gain = fading_gain(transition, np.array([[1.0, 0.0]]), np.array([0.1]), math.exp(0.02))
    assert gain[1, 0] == 0.0
    assert np.isfinite(gain).all()
