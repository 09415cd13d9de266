import math

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.block import value_at
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.identification import propose
from hydroservo.identification.trial import (
    bounds_of,
    candidates,
    keeps_bounds,
    rolled_candidate,
    room_in_bounds,
)
from tests.support.synthetic_logs import NOISE, SCENARIO, exact_log

pytestmark = pytest.mark.slow  # each fits a log

CALM = {  # a demand that excites next to nothing
    "simulation.duration": "1 s",
    "simulation.record_period": "1 ms",
    "simulation.substeps": 3,
    "plant.start_position": "39 mm",
    "reference.type": "Sine",
    "reference.amplitude": "5 mm/s",
    "reference.frequency": "1 Hz",
}
ASKED = ("plant.mass", "plant.bulk_modulus")
RANGES = dict.fromkeys((*ASKED, "valve.time_constant"), "-40%..+70%")
WRONG = {"plant.mass": 7.0}
PLAYED = {path: value for path, value in CALM.items() if not path.startswith("reference.")}
PLAYED |= {"controls.type": "Command", "controller.type": "OpenLoop", "reference.type": "Recorded"}


def noisy(exact, seed):
    rng = np.random.default_rng(seed)
    return exact | {
        name: exact[name] + rng.normal(scale=one, size=exact[name].size) for name, one in NOISE.items()
    }


@pytest.fixture(scope="module")
def log():
    return noisy(exact_log(CALM), 0)


@pytest.fixture(scope="module")
def found(log):
    return hs.identify(SCENARIO, log, RANGES, changes=CALM | WRONG, threads=1)


@pytest.fixture(scope="module")
def proposed(found):
    return propose(found, limits={"position": (0.02, 0.06)})


def width(one):
    return math.log(one.high / one.low)


def test_no_number_is_surer_than_white_noise_leaves_it(found):
    sure = found.fitted.sure
    prior = np.diag([one.prior for one in found.fitted.problem.unknowns])
    white = np.sqrt(np.diag(np.linalg.inv(sure.information + prior)))
    assert (sure.deviations > 0.999 * white).all()
    truth = hs.load_scenario(SCENARIO, CALM)
    for path, one in found.parameters.items():
        assert one.low < value_at(truth, path) < one.high, path


def test_a_log_of_the_proposed_command_narrows_intervals_as_promised(found, proposed, log, tmp_path):
    assert not found.parameters["plant.bulk_modulus"].identifiable
    assert "plant.bulk_modulus" in proposed.asked
    file = tmp_path / "next.csv"
    file.write_text(proposed.csv(), encoding="utf-8")
    played = exact_log(PLAYED | {"reference.series": {"file": str(file)}})
    np.testing.assert_allclose(played["command"], proposed.command, rtol=1e-5, atol=1e-9)
    again = hs.identify(SCENARIO, [log, noisy(played, 1)], RANGES, changes=CALM | WRONG, threads=1)
    truth = hs.load_scenario(SCENARIO, CALM)
    for path in ASKED:
        one, promise = again.parameters[path], proposed.promises[path]
        assert one.identifiable
        assert promise.times > 3.0
        assert 0.5 < width(one) / width(promise) < 2.0, path
        assert abs(math.log(one.value / value_at(truth, path))) < 2.0 * width(promise)


def test_limits_are_kept_by_the_true_machine_too(proposed, tmp_path):
    file = tmp_path / "next.csv"
    file.write_text(proposed.csv(), encoding="utf-8")
    run = hs.simulate(hs.load_scenario(SCENARIO, PLAYED | {"reference.series": {"file": str(file)}}))
    assert run["plant.position"].min() >= 0.02
    assert run["plant.position"].max() <= 0.06
    assert np.abs(run["controller.u"]).max() <= proposed.bounds["command"][1]
    low, high = proposed.reached["position"]
    assert 0.02 <= low < high <= 0.06


def test_the_same_seed_proposes_the_same(found, proposed):
    again = propose(found, limits={"position": (0.02, 0.06)})
    np.testing.assert_array_equal(again.command, proposed.command)
    assert again.promises == proposed.promises


def test_limits_that_are_none_are_refused(found):
    with pytest.raises(ParameterError, match="is not a signal"):
        propose(found, limits={"speed": (0.0, 1.0)})
    with pytest.raises(ParameterError, match="lower end first"):
        propose(found, limits={"position": (0.06, 0.02)})
    with pytest.raises(HydroservoError, match="no command tried stays within the limits"):
        propose(found, limits={"position": (0.0, 0.001)})


def test_candidates_are_as_large_as_they_may_be_and_move_nothing_in_the_end():
    found = candidates(1000, 1e-3, 3)
    assert len({one.name for one in found}) == len(found)
    for one in found:
        assert np.abs(one.values).max() == pytest.approx(1.0)
        assert abs(one.values.mean()) < 1e-12
        up = np.cumsum(rolled_candidate(one, 0.0).values)
        assert up.min() > -1.0 - 1e-9  # a sample's step at most
        assert np.cumsum(rolled_candidate(one, 1.0).values).max() < 1.0 + 1e-9


def test_bounds_are_those_of_the_machine_but_for_those_given():
    loop = hs.load_scenario(SCENARIO, CALM)
    own = bounds_of(loop, {"pressure_a": (1e5, 3e6)})
    assert own["position"] == pytest.approx((0.02 * 0.078, 0.98 * 0.078))
    assert own["pressure_a"] == (1e5, 3e6)
    assert own["pressure_b"] == (0.0, pytest.approx(1.5 * 40e5))
    assert own["command"] == (-10.0, 10.0)


def test_bounds_know_what_leaves_them():
    shown = np.zeros((10, 6, 2))
    shown[:, 2, 1] = np.linspace(0.0, 0.4, 10)
    assert keeps_bounds(shown, {"position": (-0.1, 0.5)})
    assert not keeps_bounds(shown, {"position": (-0.1, 0.3)})
    assert room_in_bounds(shown, {"position": (-0.1, 0.3)}) == pytest.approx(1.0)
    shown[3, 0, 0] = np.nan
    assert not keeps_bounds(shown, {"position": (-0.1, 0.5)})
    assert room_in_bounds(shown, {"position": (-0.1, 0.5)}) == 0.0
