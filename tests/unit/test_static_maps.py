"""What maps are made of, and logs from which none follows."""

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.identification.maps.friction import friction_values
from hydroservo.identification.maps.friction_law import fitted_friction
from hydroservo.identification.maps.result import Interval
from hydroservo.identification.regression import regression
from hydroservo.machine.mechanics import ElastoPlastic, LuGre
from tests.support.map_logs import scenario

TIME = np.linspace(0.0, 20.0, 4001)


def decaying(leak=2e-13, noise=0.0, rise=0.0):
    """Pressures of the example's locked cylinder, in closed form without leakage to the outside."""
    plant = hs.load_scenario(scenario("decay")).plant
    a, b = plant.volume_a(0.2), plant.volume_b(0.2)
    rate = plant.oil.effective_bulk_modulus * leak * (1.0 / a + 1.0 / b)
    apart = 9e6 * np.exp(-rate * TIME) + rise * TIME
    mean = (a * 1e7 + b * 1e6) / (a + b)
    noisy = np.random.default_rng(0).normal(scale=noise, size=(2, TIME.size))
    return {
        "time": TIME,
        "pressure_a": mean + b / (a + b) * apart + noisy[0],
        "pressure_b": mean - a / (a + b) * apart + noisy[1],
    }


def swept(rate=0.05, amplitude=1.0, delay=0.0):
    """A valve of 0.4 V of overlap, in closed form, behind a delay."""
    command = amplitude * np.sin(2.0 * np.pi * rate * TIME)
    late = amplitude * np.sin(2.0 * np.pi * rate * (TIME - delay))
    velocity = 0.1 * np.sign(late) * np.maximum(np.abs(late) - 0.4, 0.0)
    return {"time": TIME, "command": command, "velocity": velocity + 1e-6 * np.cos(77.0 * TIME)}


def strokes(speeds, friction, noise=0.05):
    """Moves of 2 s to and fro at each speed, of a machine whose friction also depends on where it is."""
    rng = np.random.default_rng(5)
    velocity = np.concatenate(
        [np.full(200, sign * v) for v in speeds for _ in range(3) for sign in (1.0, -1.0)]
    )
    along = np.tile(np.linspace(-1.0, 1.0, 200), velocity.size // 200)
    force = friction(velocity) + np.sign(velocity) * 0.6 * (along**2 - 1.0 / 3.0)
    noisy = force + rng.normal(scale=noise, size=force.size)
    return {"time": 0.01 * np.arange(force.size), "velocity": velocity, "hydraulic_force": noisy}


def coulomb(velocity):
    """9 N, whatever the speed."""
    return 9.0 * np.sign(velocity)


@pytest.mark.parametrize("speeds", [[0.013], [0.011, 0.014], [0.011, 0.0125, 0.014]])
def test_at_one_speed_each_way_the_sum_alone_is_told(speeds):
    found = hs.map_logs("friction", strokes(speeds, coulomb), scenario("friction"))
    assert set(found.numbers) == {"friction"}
    both = found.numbers["friction"]
    assert both.low < 9.0 < both.high
    assert both.high - both.low < 2.0
    assert "together at 1" in both.meaning
    assert "cannot be told apart, so only their sum is given" in found.remarks[0]
    assert found.tables == {}


def test_a_sum_at_one_speed_one_way_has_the_constant_force_in_it():
    log = strokes([0.013], coulomb)
    forth = {"velocity": np.abs(log["velocity"]) + 1e-6 * np.cos(log["time"])}
    found = hs.map_logs("friction", log | forth | {"hydraulic_force": 7.0 + np.abs(log["hydraulic_force"])})
    assert found.numbers["friction"].value == pytest.approx(16.0, abs=0.3)
    assert "any constant force" in found.numbers["friction"].meaning


def test_a_force_that_goes_with_the_motion_is_no_friction():
    with pytest.raises(ScenarioError, match="hydraulic_force or velocity is reversed") as caught:
        hs.map_logs("friction", strokes([0.013], lambda v: -coulomb(v)))
    assert "a friction of -9.00 N" in str(caught.value)


@pytest.mark.parametrize(
    ("friction", "said"),
    [
        (lambda v: np.sign(v) * (9.0 + 6.0 / (1.0 + (v / 0.02) ** 2)), "friction falls with speed"),
        (lambda v: np.sign(v) * 4e4 * v**2, "friction rises faster than speed"),
    ],
)
def test_what_no_coulomb_and_viscous_friction_does_is_said(friction, said):
    found = hs.map_logs("friction", strokes([0.01, 0.02, 0.04], friction), scenario("friction"))
    assert found.numbers == {}
    assert said in found.remarks[-1]
    assert found.tables == {}


@pytest.mark.parametrize("dry", [0.0, 100.0])
@pytest.mark.parametrize("viscous", [0.0, 900.0])
def test_intervals_of_friction_hold_the_truth_and_nothing_impossible(dry, viscous):
    held, runs = 0, 60
    v = np.repeat([-0.3, -0.15, -0.06, 0.06, 0.15, 0.3], 2)
    for seed in range(runs):
        noise = np.random.default_rng(seed).normal(scale=2.0, size=v.size)
        found = fitted_friction(v, np.sign(v) * dry + viscous * v + 5.0 + noise, np.full(v.size, 2.0), False)
        if not found.numbers:  # a chance of 5 % for each that is 0
            continue
        one, other = found.numbers["coulomb"], found.numbers["viscous"]
        assert min(*one[:3], *other[:3]) >= 0.0
        held += one.low <= dry <= one.high and other.low <= viscous <= other.high
    assert held >= 0.8 * runs


def test_a_lag_that_makes_more_than_is_seen_leaves_no_hysteresis():
    found = hs.map_logs("valve-flow", swept(), scenario("machine"))
    assert "hysteresis" not in found.numbers
    assert "a lag of 4.90 ms makes" in found.undetermined["hysteresis"]
    assert "hysteresis cannot be determined" in repr(found)
    assert "hysteresis" not in found.tables["valve"]


def test_without_a_pressure_the_area_of_the_edges_stays_that_of_the_scenario():
    found = hs.map_logs("valve-flow", swept(), scenario("machine"))
    own = hs.load_scenario(scenario("machine")).valve.orifice.area_gradient
    assert found.tables["truth"]["valve"]["orifice"]["area_gradient"] == own


@pytest.mark.parametrize("noise", [1e3, 2e4, 2e5])
def test_no_leakage_is_below_0(noise):
    found = hs.map_logs("decay", decaying(noise=noise), scenario("decay"))
    outside = found.numbers["external_leakage"]
    assert 0.0 <= outside.low <= outside.value <= outside.high
    assert any("external_leakage cannot be told from none" in line for line in found.remarks)


@pytest.mark.parametrize("noise", [1e3, 5e4])
def test_an_empty_chambers_noise_is_no_leakage_into_it(noise):
    """p_A = p_0 exp(-beta C_e t/V_A) by leakage to the outside alone, and p_B = 0."""
    plant = hs.load_scenario(scenario("decay")).plant
    leak = 1e-14
    decayed = 1e7 * np.exp(-plant.oil.effective_bulk_modulus * leak / plant.volume_a(0.2) * TIME)
    noisy = np.random.default_rng(2).normal(scale=noise, size=(2, TIME.size))
    log = {"time": TIME, "pressure_a": decayed + noisy[0], "pressure_b": noisy[1]}
    found = hs.map_logs("decay", log, scenario("decay"))
    inside, outside = found.numbers["internal_leakage"], found.numbers["external_leakage"]
    assert inside.low == 0.0
    assert inside.high < 0.02 * leak
    assert outside.low < leak < outside.high
    assert "internal_leakage" not in found.tables["plant"]


def test_pressures_that_rise_together_are_no_decay():
    log = decaying(noise=1e3)
    warmer = {key: one + 3e4 * TIME for key, one in log.items() if key != "time"}
    with pytest.raises(ScenarioError, match="both pressures rise together"):
        hs.map_logs("decay", log | warmer, scenario("decay"))


def test_a_decay_in_closed_form_is_met():
    found = hs.map_logs("decay", decaying(), scenario("decay"))
    assert found.numbers["internal_leakage"].value == pytest.approx(2e-13, rel=1e-3)
    assert found.tables["plant"]["internal_leakage"] == found.numbers["internal_leakage"].value
    assert "external_leakage" not in found.tables["plant"]


def test_the_time_constant_is_that_of_the_closed_form():
    found = hs.map_logs("decay", decaying(4e-13), scenario("decay"))
    apart = decaying(4e-13)["pressure_a"] - decaying(4e-13)["pressure_b"]
    rate = -np.polyfit(TIME[:100], np.log(apart[:100]), 1)[0]
    assert found.numbers["time_constant"].value == pytest.approx(1.0 / rate, rel=1e-3)


def test_a_load_pressure_decays_by_its_leakage_in_closed_form():
    """F = F_0 exp(-4 beta C_tl t/V_t), piston held: Merritt, Hydraulic Control Systems, 1967, ch. 6."""
    plant = hs.load_scenario("rig/1khz-pi-sine").plant
    leak = 1e-3 * plant.leakage  # slow beside the samples
    rate = 4.0 * plant.bulk_modulus * leak / plant.total_volume
    log = {"time": TIME, "hydraulic_force": 800.0 * np.exp(-rate * TIME)}
    found = hs.map_logs("decay", log, "rig/1khz-pi-sine")
    assert found.numbers["internal_leakage"].value == pytest.approx(leak, rel=1e-3)
    assert found.numbers["time_constant"].value == pytest.approx(1.0 / rate, rel=1e-3)
    assert found.tables["plant"]["leakage"] == found.numbers["internal_leakage"].value
    assert "external_leakage" not in found.numbers
    product = plant.bulk_modulus * leak  # of which the scenario's leakage gives the bulk modulus
    assert found.numbers["bulk_modulus"].value == pytest.approx(product / plant.leakage, rel=1e-3)


def test_a_load_that_moves_a_locked_piston_tells_both_numbers_of_a_load_pressure():
    """V_t/(4 beta) dF/dt = -A^2 v - C_tl F, solved by hand: F' = -r F - P cos(w t) of x = X sin(w t)."""
    plant = hs.load_scenario("rig/1khz-pi-sine").plant
    modulus, leak, w, reach = 1.3e9, 1e-3 * plant.leakage, 2.0, 2e-5
    rate = 4.0 * modulus * leak / plant.total_volume
    push = 4.0 * modulus * plant.piston_area**2 / plant.total_volume * reach * w
    forced = -push * (rate * np.cos(w * TIME) + w * np.sin(w * TIME)) / (rate**2 + w**2)
    force = forced + (800.0 - forced[0]) * np.exp(-rate * TIME)
    log = {"time": TIME, "hydraulic_force": force, "position": 0.04 + reach * np.sin(w * TIME)}
    found = hs.map_logs("decay", log, "rig/1khz-pi-sine")
    assert found.numbers["bulk_modulus"].value == pytest.approx(modulus, rel=1e-3)
    assert found.numbers["internal_leakage"].value == pytest.approx(leak, rel=1e-3)
    assert found.tables["plant"]["bulk_modulus"] == found.numbers["bulk_modulus"].value


def test_a_valve_in_closed_form_is_met_and_its_delay_is_hysteresis():
    found = hs.map_logs("valve-flow", swept(), scenario("machine"))
    area = hs.load_scenario(scenario("machine")).plant.area_a
    assert found.numbers["flow_gain_plus"].value == pytest.approx(0.1 * area, rel=1e-3)
    assert found.numbers["dead_band_plus"].value == pytest.approx(0.4, abs=2e-3)
    assert found.numbers["dead_band_minus"].value == pytest.approx(-0.4, abs=2e-3)
    assert any("no pressure_a" in line for line in found.remarks)


def test_a_scenario_with_what_was_found_is_that_machine(tmp_path):
    found = hs.map_logs("decay", decaying(5e-13), scenario("decay"))
    path = tmp_path / "found.toml"
    path.write_text(found.toml(tmp_path))
    assert hs.load_scenario(path).plant.internal_leakage == found.numbers["internal_leakage"].value


@pytest.mark.parametrize(
    ("kind", "log", "said"),
    [
        ("valve-flow", swept(rate=0.2, delay=0.15), "the sweep is too fast"),
        ("valve-flow", swept(rate=0.005), "a sweep one way only"),
        ("valve-flow", swept(amplitude=0.3), "shows no positive flow"),
        (
            "valve-flow",
            {key: one for key, one in swept().items() if key != "velocity"} | {"force": TIME},
            "velocity",
        ),
        (
            "valve-flow",
            swept() | {"position": 200.0 + np.sin(TIME)},
            "the scenario's piston between 0 and 400",
        ),
        ("pressure-gain", swept(), "the piston moves"),
        ("friction", swept(), 'no column "pressure_a [Pa]" or "hydraulic_force [N]" is there'),
        (
            "friction",
            {"time": TIME, "velocity": np.sin(20.0 * TIME), "hydraulic_force": TIME},
            "at a constant speed",
        ),
        ("decay", swept(), 'no column "pressure_a [Pa]"'),
        ("decay", decaying(0.0, noise=1e3), "do not decay beyond their noise"),
        ("decay", decaying(0.0, noise=1e3, rise=1e5), "do not decay"),
        ("decay", decaying() | {"command": np.sin(TIME)}, "changes by 2.00 V"),
    ],
)
def test_a_log_of_the_wrong_kind_is_one_line(kind, log, said):
    with pytest.raises(ScenarioError) as caught:
        hs.map_logs(kind, log, scenario("decay" if kind == "decay" else "machine"))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("flow", swept(), None), "kind"),
        (("decay", decaying(), None), "needs one"),
        (("decay", [], scenario("decay")), "must be at least one"),
        (("friction", decaying() | {"speed": TIME}, None), "is not a signal"),
    ],
)
def test_what_is_no_argument_is_refused(arguments, said):
    with pytest.raises(ParameterError, match=said):
        hs.map_logs(*arguments)


@pytest.mark.parametrize("gaussian", [False, True])
def test_a_law_of_friction_is_found_with_its_fall(gaussian):
    speeds = np.geomspace(0.002, 0.5, 12)
    v = np.concatenate([-speeds, speeds])
    squares = (v / 0.02) ** 2
    fall = np.exp(-squares) if gaussian else 1.0 / (1.0 + squares)
    force = np.sign(v) * (200.0 + 80.0 * fall) + 900.0 * v + 15.0
    noisy = force + np.random.default_rng(3).normal(scale=1.0, size=v.size)
    found = fitted_friction(v, noisy, np.ones(v.size), gaussian)
    true = {"coulomb": 200.0, "breakaway": 280.0, "stribeck_velocity": 0.02, "viscous": 900.0, "offset": 15.0}
    for name, value in true.items():
        one = found.numbers[name]
        assert one.low - 0.5 * (one.high - one.low) < value < one.high + 0.5 * (one.high - one.low), name


def test_without_a_fall_none_is_told():
    v = np.concatenate([-np.geomspace(0.01, 0.5, 8), np.geomspace(0.01, 0.5, 8)])
    noisy = np.sign(v) * 200.0 + 900.0 * v + np.random.default_rng(3).normal(scale=1.0, size=v.size)
    found = fitted_friction(v, noisy, np.ones(v.size), False)
    assert set(found.numbers) == {"coulomb", "viscous", "offset"}
    assert "cannot be determined" in found.remarks[0]


def test_intervals_of_a_regression_hold_the_truth_where_noise_hangs_together():
    held, runs = 0, 200
    x = np.linspace(-1.0, 1.0, 2000)
    for seed in range(runs):
        white = np.random.default_rng(seed).normal(size=x.size)
        noise = np.convolve(white, 0.9 ** np.arange(60))[: x.size]
        found = regression([(np.stack([x, np.ones(x.size)], axis=1), 2.0 * x + noise)])
        held += abs(found.values[0] - 2.0) < found.half(np.array([1.0, 0.0]))
    assert 0.88 * runs < held <= runs


def test_columns_that_are_alike_are_no_regression():
    x = np.linspace(0.0, 1.0, 50)
    assert regression([(np.stack([x, 2.0 * x], axis=1), x)]) is None


@pytest.mark.parametrize("elastic", [False, True])
def test_numbers_of_bristles_are_put_where_they_stand(elastic):
    loop = hs.load_scenario(scenario("friction"))
    bristles = LuGre(1e7, 3000.0, 200.0, 250.0, 0.02, 2000.0)
    friction = ElastoPlastic(bristles, 0.8) if elastic else bristles
    loop = loop._replace(plant=loop.plant._replace(friction=friction))
    names = {"coulomb": 180.0, "breakaway": 260.0, "stribeck_velocity": 0.025, "viscous": 2500.0}
    given = {name: Interval.around(value, 1.0, "", "") for name, value in names.items()}
    numbers, remarks = friction_values(given, loop)
    at = "plant.friction.bristles" if elastic else "plant.friction"
    assert {path: number.value for path, number in numbers.items()} == {
        f"{at}.{name}": value for name, value in names.items()
    }
    assert remarks == []
