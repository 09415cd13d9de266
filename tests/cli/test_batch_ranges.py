"""``hydroservo batch``: the ranges that --vary takes, and what is drawn from them."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import ScenarioError
from hydroservo.cli.options import parse_ranges
from hydroservo.scenario.load import assemble
from hydroservo.scenario.parameter_draws import variations
from tests.support.commands.batches import NAME, drawn
from tests.support.commands.runner import failed, succeeded
from tests.support.commands.tuning import rows_of

pytestmark = pytest.mark.slow  # it runs and draws


@given(seed=st.integers(0, 2**63 - 1), few=st.integers(1, 20), more=st.integers(20, 60))
def test_a_run_has_the_same_parameters_whatever_their_number_and_whatever_else_varies(seed, few, more):
    mass, area = "plant.mass=4..8kg", "plant.piston_area=-10..10%"
    _, one = drawn(mass, seed=seed, runs=few)
    _, other = drawn(area, mass, seed=seed, runs=more, seeds=True)
    for path in one.parameters:
        np.testing.assert_array_equal(one.parameters[path], other.parameters[path][:few])
    for path in one.deviations:
        np.testing.assert_array_equal(one.deviations[path], other.deviations[path][:few])


def test_another_seed_and_another_path_draw_other_numbers():
    _, one = drawn("plant.mass=1..2", "controller.velocity_gain=1..2", runs=1000)
    _, other = drawn("plant.mass=1..2", seed=1, runs=1000)
    mass, gain = one.parameters["plant.mass"], one.parameters["controller.velocity_gain"]
    assert abs(np.corrcoef(mass, gain)[0, 1]) < 0.1
    assert abs(np.corrcoef(mass, other.parameters["plant.mass"])[0, 1]) < 0.1


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("plant.bulk_modulus=0.5e9 Pa..1.5e9 Pa", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=0.5..1.5 GPa", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=5000 bar .. 1.5 GPa", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=5e8..1.5e9", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=-30%..+30%", 4.9e8, 9.1e8),
        ("plant.bulk_modulus = -30 .. 30 %", 4.9e8, 9.1e8),
        ("plant.bulk_modulus=\N{MINUS SIGN}30..30%", 4.9e8, 9.1e8),
        ("plant.bulk_modulus=0%..+30%", 7e8, 9.1e8),
        ("plant.bulk_modulus=x0.5..x2", 3.5e8, 14e8),
        ("plant.bulk_modulus = x 1/2 .. x 2", 3.5e8, 14e8),
        ("valve.orifice.discharge_coefficient=1/2..5/7", 0.5, 5 / 7),
        ("valve.orifice.discharge_coefficient=60..80%", 0.6, 0.8),
        ("valve.orifice.discharge_coefficient=-10%..+10%", 0.558, 0.682),
        ("valve.orifice.discharge_coefficient=x0.9..x1.1", 0.558, 0.682),
        ("load.offset=-50..50N", -50.0, 50.0),
        ("load.phase=-.5...5", -0.5, 0.5),
        ("controller.velocity_gain=1e2..2e2 1/s", 100.0, 200.0),
    ],
)
def test_numbers_are_spread_evenly_over_the_range(text, low, high):
    _, found = drawn(text, runs=4000)
    (path,) = found.ranges
    assert found.ranges[path] == pytest.approx((low, high), rel=1e-12)
    share = (np.sort(found.parameters[path]) - low) / (high - low)
    assert np.max(np.abs(share - (np.arange(4000) + 0.5) / 4000)) < 0.03  # Kolmogorov-Smirnov, p below 0.002


def test_percentages_of_a_negative_number_span_it():
    _, found = drawn("load.amplitude=-10..20%", changes=["load.amplitude=-100N"])
    assert found.ranges["load.amplitude"] == pytest.approx((-120.0, -90.0))
    assert np.all(
        (found.parameters["load.amplitude"] > -120.0) & (found.parameters["load.amplitude"] < -90.0)
    )


def test_a_percentage_without_a_sign_is_a_value():
    _, found = drawn("plant.oil.air_content=0.1..3%", name="axis/position")  # in which it is 0.5 %
    assert found.ranges["plant.oil.air_content"] == (0.001, 0.03)


def test_seeds_count_from_that_of_the_scenario():
    _, found = drawn(changes=["simulation.seed=7"], runs=3, seeds=True)
    assert [found.changes(i) for i in range(3)] == [{"simulation.seed": 7 + i} for i in range(3)]
    assert found.ranges == {"simulation.seed": (7, 9)}


def test_only_the_truth_of_the_machine_varies():
    loop, found = drawn("plant.mass=4..8kg")
    assert list(found.parameters) == ["plant.mass"]
    assert list(found.changes(0)) == ["truth.plant.mass"]
    assert loop.controller.model.plant.mass == 6.0


def test_what_a_law_believes_varies_alone():
    _, found = drawn("controller.model.plant.mass=4..8kg")
    assert list(found.changes(0)) == ["controller.model.plant.mass"]
    assert list(found.parameters) == ["controller.model.plant.mass"]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("plant.mss=1..2", "plant.mss: must be one of plant.mass, plant.damping, "),
        ("plant.mss=1..2", "; did you mean plant.mass?"),
        ("plnt.mass=1..2", "plnt.mass: is not a number that can vary; did you mean plant.mass?"),
        ("mass=1..2", "mass: is not a number that can vary"),
        ("nominal.plant.mass=1..2", "is not a number that can vary; did you mean "),
        ("plant=1..2", "plant: is not a number that can vary"),
        ("simulation.period=1..2", "simulation.period: is not a number that can vary"),
        ("simulation.seed=1..2", "simulation.seed: is varied by --seeds"),
        ("plant.mass", "'plant.mass' must be of the form PATH=LOW..HIGH"),
        ("plant.mass=4", "'plant.mass=4' must be of the form PATH=LOW..HIGH"),
        ("=1..2", "must be of the form PATH=LOW..HIGH"),
        (
            "plant.mass=8..4kg",
            "'8 kg' is more than '4kg', its upper end; it must be a finite number above 0 [kg]",
        ),
        ("plant.mass=30%..-30%", "'30%' is more than '-30%', its upper end"),
        ("plant.mass=4..4", "'4..4' is not a range: both ends are 4"),
        ("plant.mass=4m..8m", "plant.mass: '4m' does not convert to kg; it must be"),
        ("plant.mass=4kg..8", "'8' has no unit; write '8 kg'"),
        ("plant.mass=4..heavy", "'heavy' is not a quantity"),
        ("plant.mass=..8", "'' is not a quantity"),
        ("plant.mass=nan..8", "'nan' is not a quantity"),
        ("plant.mass=0..8kg", "'0..8kg' reaches 0; it must be a finite number above 0 [kg]"),
        ("plant.mass=-150%..0%", "reaches -3; it must be a finite number above 0 [kg]"),
        (
            "plant.mass=50..200%",
            "plant.mass: '200%' has no sign; write '+50%..+200%' for so much more than the value, or "
            "'x0.5..x2' for so many times it; it must be a finite number above 0 [kg]",
        ),
        ("valve.orifice.discharge_coefficient=0..60%", "reaches 0; it must be"),
        ("plant.mass=x0.5..2", "'x0.5' is not a quantity"),
        ("plant.mass=x2..x0.5", "'x2' is more than 'x0.5', its upper end"),
        ("plant.mass=-30%..8", "'8' has no % while '-30%' has one"),
        ("plant.mass=-30%..8kg", "'8kg' has no % while '-30%' has one"),
        ("load.offset=-30%..30%", "is 0 in the scenario, so no percentage of it can be taken"),
        ("load.offset=x0.5..x2", "is 0 in the scenario, so no percentage of it can be taken"),
        ("plant.mass=1..2\n", "plant.mass"),
        ("plant.mass=1..2 k\ng", "plant.mass: "),
        ("plant.mass=" + "1" * 5000 + "..2", "must be of the form"),
    ],
)
def test_a_wrong_range_is_one_line_that_names_it(text, problem):
    if text == "plant.mass=1..2\n":
        assert drawn(text)[1].ranges == {"plant.mass": (1.0, 2.0)}
        return
    message = failed("batch", NAME, "--runs", "2", "--vary", text)
    assert message.startswith("hydroservo: --vary: ")
    assert problem in message
    assert message.rstrip("\n").isprintable()


@given(text=st.text(max_size=20) | st.text("0123456789.%-+x kgPa", max_size=12).map("plant.mass={}".format))
def test_any_range_is_drawn_from_or_refused_in_one_line(text):
    try:
        (found,) = variations(assemble(NAME), parse_ranges([text]))
    except ScenarioError as error:
        found = str(error)
    assert found.isprintable() if isinstance(found, str) else 0.0 < found.low < found.high


def test_a_table_has_one_unit_a_quantity_as_it_was_typed():
    words = ("batch", "axis/position", "--set", "simulation.duration=2ms", "--runs", "2")
    ends = {
        "plant.line_volume_a": "100..200 ml",
        "plant.line_volume_b": "2e-4..3e-4",
        "plant.start_position": "0.1..0.2 m",
        "plant.oil.air_content": "0.1..3%",
        "plant.mechanism.mass": "-10%..+10%",
    }
    ranges = [word for path, text in ends.items() for word in ("--vary", f"{path}={text}")]
    rows = rows_of(succeeded(*words, *ranges))
    assert rows["plant.line_volume_a"][:3] == ["100", "200", "ml"]
    assert rows["plant.line_volume_b"][:3] == ["200", "300", "ml"]
    assert rows["plant.start_position"][:3] == ["0.1", "0.2", "m"]
    assert rows["plant.oil.air_content"][:3] == ["0.1", "3", "%"]
    assert rows["plant.mechanism.mass"][2] == "kg"


def test_temperatures_are_shown_in_degrees_celsius():
    oil = {"type": "AeratedOil.at_temperature", "cold": "293.15 K", "hot": "353.15 K"}
    oil |= {"temperature": "313.15 K", "cold_bulk_modulus": "15000 bar", "hot_bulk_modulus": "11000 bar"}
    changes = [word for name, text in oil.items() for word in ("--set", f"plant.oil.{name}={text}")]
    words = ("batch", "axis/position", "--set", "simulation.duration=2ms", "--runs", "2", *changes)
    vary = ("--vary", "plant.oil.temperature=293.15..333.15K")
    assert rows_of(succeeded(*words, *vary))["plant.oil.temperature"][:3] == ["20", "60", "degC"]
    said = json.loads(succeeded(*words, *vary, "--json"))
    assert said["varied"]["plant.oil.temperature"] == [293.15, 333.15]
