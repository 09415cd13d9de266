"""How finely machines are followed while numbers are sought."""

import numpy as np
import pytest

from tests.support.commanded_logs import fit, moves

pytestmark = pytest.mark.slow  # it runs and draws

SLOW = {"valve.gain": "0.03 mm/V"}
FAST = {"valve.gain": "0.3 mm/V"}  # of which the piston runs into its end stops
FOUR = {
    "valve.gain": "0.01..0.5 mm/V",
    "valve.time_constant": "5..100 ms",
    "plant.mechanism.mass": "20..300 kg",
    "load.amplitude": "0..4 kN",
}
MOST = (
    200 * 50
)  # evaluations times steps in a sample: of a thousand steps and as many evaluations, a twentieth


def steps(found):
    (one,) = found.fitted.problem.experiments
    return one.loop.simulation.substeps


@pytest.fixture(scope="module")
def log():
    return moves(SLOW, signals=("velocity",), volts=1.5)


def test_machines_at_their_end_stops_do_not_slow_a_search(log):
    found = fit(log, {"valve.gain": FOUR["valve.gain"]}, FAST)
    assert found.parameters["valve.gain"].value == pytest.approx(3e-5, rel=2e-3)
    assert found.evaluations * steps(found) < MOST
    found = fit(log, FOUR, FAST | {"valve.time_constant": "80 ms"})
    assert found.evaluations * steps(found) < MOST
    for path, value in {"valve.gain": 3e-5, "valve.time_constant": 0.03, "load.amplitude": 2e3}.items():
        assert found.parameters[path].value == pytest.approx(value, rel=5e-2)


def test_a_log_of_end_stops_is_met_whatever_the_scenario_believes():
    log = moves(signals=("velocity",), volts=2.0)
    for gain in ("0.05 mm/V", "0.25 mm/V"):
        found = fit(log, {"valve.gain": "0.02..0.3 mm/V"}, {"valve.gain": gain})
        assert found.parameters["valve.gain"].value == pytest.approx(1e-4, rel=1e-3)


def test_steps_become_finer_for_what_little_is_left():
    beliefs = {"valve.gain": "0.05 mm/V", "simulation.tolerance": 1e-7}
    exact, rough = (
        fit(moves(quiet=quiet), {"valve.gain": "0.02..0.3 mm/V"}, beliefs) for quiet in (True, False)
    )
    assert steps(exact) > steps(rough)
    assert exact.parameters["valve.gain"].value == pytest.approx(1e-4, rel=1e-6)


def test_steps_that_a_scenario_gives_stay(log):
    found = fit(log, {"valve.gain": FOUR["valve.gain"]}, {"simulation.substeps": 7})
    assert steps(found) == 35


def test_any_number_of_threads_finds_the_same_bits(log):
    one, two = (fit(log, FOUR, FAST, threads=threads) for threads in (1, 2))
    assert one.parameters == two.parameters
    np.testing.assert_array_equal(one.fitted.best.x, two.fitted.best.x)
