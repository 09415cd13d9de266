"""Which numbers of a machine can be sought in a log, beside which others."""

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.errors import ScenarioError
from tests.support.axes import AXIS
from tests.support.commanded_logs import LOADED, fit, moves

FLOW = "valve.orifice.rated_flow"
VERTICAL = {"plant.mechanism.rise": 1, "load.amplitude": "4 kN"}


@pytest.fixture(scope="module")
def log():
    return moves(late=4)


@pytest.mark.parametrize(
    ("ranges", "beliefs", "truth"),
    [
        (
            {FLOW: "20..80 L/min", "valve.time_constant": "5..100 ms"},
            {FLOW: "60 L/min", "valve.time_constant": "50 ms"},
            {FLOW: 40.0 / 6e4, "valve.time_constant": 0.03},
        ),
        (
            {"plant.bore": "30..60 mm", "plant.mechanism.mass": "20..300 kg"},
            {"plant.bore": "50 mm"},
            {"plant.bore": 0.04},
        ),
        (
            {FLOW: "20..80 L/min", "valve.orifice.lap": "-0.02..0.05 mm"},
            {FLOW: "60 L/min"},
            {FLOW: 40.0 / 6e4},
        ),
        ({"load.amplitude": "0..5 kN"}, {"load.amplitude": "1 kN"}, {"load.amplitude": 2e3}),
    ],
)
def test_numbers_of_constructors_and_of_the_load_are_found(log, ranges, beliefs, truth):
    found = fit(log, ranges, beliefs)
    for path, value in truth.items():
        assert found.parameters[path].identifiable
        assert found.parameters[path].value == pytest.approx(value, rel=2e-3)
    assert found.logs[0].delay[0] == pytest.approx(0.02, abs=1e-4)


def test_a_number_that_follows_from_what_varies_names_that_alone(log):
    ranges = {"plant.rod": "20..24 mm", "plant.bore": "35..45 mm", "plant.area_a": "10..15 cm^2"}
    with pytest.raises(ScenarioError, match=r"plant\.area_a: follows from plant\.bore, which varies too"):
        fit(log, ranges)


def test_constructors_whose_numbers_do_not_go_together_are_left_out(log):
    found = fit(log, {"plant.bore": "15..60 mm", "plant.rod": "15..40 mm"}, {"plant.bore": "45 mm"})
    assert found.parameters["plant.bore"].value == pytest.approx(0.04, rel=2e-3)
    assert found.parameters["plant.rod"].value == pytest.approx(0.022, rel=2e-2)


def test_machines_that_cannot_hold_their_load_are_left_out():
    found = fit(moves(VERTICAL), {"supply.supply_pressure": "30..200 bar"}, VERTICAL)
    assert found.parameters["supply.supply_pressure"].value == pytest.approx(1e7, rel=2e-3)


def test_a_load_is_sought_only_where_no_force_was_recorded(log):
    forced = log | {"external_force": np.full_like(log["time"], 2e3)}
    ranges = {"load.amplitude": "0..5 kN"}
    with pytest.raises(ScenarioError, match="the logs' external_force takes the place of the load"):
        fit(forced, ranges)
    both = hs.identify(AXIS, [forced, log], ranges, changes=LOADED, threads=1)
    assert both.parameters["load.amplitude"].value == pytest.approx(2e3, rel=2e-3)
