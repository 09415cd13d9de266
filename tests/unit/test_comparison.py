import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.errors import ParameterError
from hydroservo.identification import compare
from hydroservo.identification.conclusions import independent_samples
from tests.support.synthetic_logs import SCENARIO, SHORT, exact_log, recorded

pytestmark = pytest.mark.slow  # each fits a log

BRIEF = SHORT | {"simulation.duration": "0.5 s", "reference.period": "0.2 s"}
SMALL = dict.fromkeys(("plant.bulk_modulus", "valve.time_constant"), "-40%..+70%")
LARGE = SMALL | {"plant.mass": "-40%..+70%"}
STICKS = "cases/stick-slip"
MOVES = {"uncertainty.scale": 0.0, "simulation.duration": "1.2 s", "reference.amplitude": "20 mm/s"}
COULOMB = {  # its fall with velocity is taken away: 1 kN at any speed
    "plant.friction.type": "Stribeck",
    "plant.friction.coulomb": "1 N",
    "plant.friction.breakaway": "1000 N",
    "plant.friction.stribeck_velocity": "1e6 m/s",
    "plant.friction.viscous": "1000 N s/m",
    "plant.friction.stop_time": "1 ms",
}
BOTH = {"plant.mechanism.mass": "-40%..+70%", "plant.friction.viscous": "-60%..+150%"}
OF_LUGRE = BOTH | {
    "plant.friction.coulomb": "300..1200 N",
    "plant.friction.breakaway": "1200..4000 N",
    "plant.friction.bristle_stiffness": "-60%..+150%",
    "plant.friction.stribeck_velocity": "-60%..+150%",
}
OF_COULOMB = BOTH | {"plant.friction.breakaway": "300..4000 N"}


@pytest.mark.parametrize(("mass", "earns"), [(6.0, False), (6.6, True)])
def test_a_number_is_earned_where_it_is_another_than_the_scenario_says(mass, earns):
    log = recorded(exact_log(BRIEF | {"plant.mass": mass}), 0)
    both = [
        hs.identify(SCENARIO, log, ranges, changes=BRIEF | {"plant.mass": 6.0}, threads=1)
        for ranges in (SMALL, LARGE)
    ]
    said = compare(*both)
    assert said == compare(*reversed(both))
    assert (said.earns, said.numbers) == (earns, 1)
    assert (said.criterion > 10.0) == earns
    if not earns:  # what a number costs that explains nothing: ln n, less half a square of a normal one
        assert -np.log(said.independent) - 1.0 < said.criterion < 4.0
    assert ("earns its one more number" in str(said)) == earns


def test_what_cannot_be_compared_is_refused():
    log = recorded(exact_log(BRIEF), 0)
    found = hs.identify(SCENARIO, log, SMALL, changes=BRIEF, threads=1)
    with pytest.raises(ParameterError, match="one must have more"):
        compare(found, found)
    other = found._replace(horizon=0.1, parameters={})
    with pytest.raises(ParameterError, match="same horizon"):
        compare(found, other)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_residuals_that_hang_together_are_fewer(rho):
    rng = np.random.default_rng(3)
    noise = rng.normal(size=40_000)
    row = np.empty_like(noise)
    row[0] = noise[0]
    for k in range(1, row.size):
        row[k] = rho * row[k - 1] + noise[k]
    assert independent_samples(row) / row.size == pytest.approx((1.0 - rho) / (1.0 + rho), rel=0.12)


def bench_log(changes, seed):
    """Velocity, position and both pressures of the axis, with noise."""
    run = hs.simulate(hs.load_scenario(STICKS, changes))
    rng = np.random.default_rng(seed)
    noise = {"velocity": 5e-4, "position": 2e-6, "pressure_a": 5e3, "pressure_b": 5e3}
    log = {"time": run.time.values, "command": run["controller.u"].values}
    return log | {
        name: run[f"plant.{name}"].values + one * rng.normal(size=run.time.size)
        for name, one in noise.items()
    }


@pytest.mark.nightly  # three searches each
@pytest.mark.parametrize(("truth", "earns"), [({}, True), (COULOMB, False)])
def test_lugre_earns_its_numbers_where_friction_is_lugre_alone(truth, earns):
    log = bench_log(MOVES | truth, 0)
    lugre = hs.identify(STICKS, log, OF_LUGRE, changes=MOVES)
    coulomb = hs.identify(STICKS, log, OF_COULOMB, changes=MOVES | COULOMB)
    said = compare(lugre, coulomb)
    assert said.numbers == 3
    assert said.earns == earns
    assert (said.held_out_ratio < 1.0) == earns
