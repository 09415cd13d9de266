"""The characteristic of a bent valve from sweeps and stairs, against the curve that made the logs."""

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.control.controllers import PID, CharacteristicCompensation
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ScenarioError
from tests.support.characteristic_logs import HYSTERESIS, drawn_valve, kinked, stairs, sweep
from tests.support.map_logs import scenario
from tests.support.tiers import mostly

SHARE = 0.01  # of full flow, that the table may be off
OFF = 0.05  # that the ends of a dead band and a hysteresis may be off [V]
DEAD_BAND = ("dead_band_plus", "dead_band_minus", "dead_band", "null_offset")

EXPERIMENTS = {
    "sweep": sweep,
    "late sweep": lambda seed: sweep(seed, lag=0.04),
    "stairs": stairs,
}
CASES = [(name, seed) for name in EXPERIMENTS for seed in range(6)]


def mapped(log):
    return hs.map_logs("characteristic", log)


def curve_of(found):
    table = found.characteristic
    return table["command"].values, table["speed"].values


def straight(command):
    """A valve without a dead band."""
    return 0.05 * command


@pytest.mark.parametrize(
    ("name", "seed"), mostly(pytest.mark.slow, CASES, [("sweep", 0), ("late sweep", 0), ("stairs", 0)])
)
def test_the_table_is_the_curve_within_1_per_cent_of_full_flow(name, seed):
    found = mapped(EXPERIMENTS[name](seed))
    command, speed = curve_of(found)
    assert 2 <= command.size <= 512
    assert (np.diff(command) > 0.0).all()
    assert (np.diff(speed) >= 0.0).all()
    assert command[0] < -9.8
    assert command[-1] > 9.8
    played = Curve.from_samples(command, speed)  # as a scenario reads it
    places = np.linspace(command[0], command[-1], 2001)
    apart = np.array([played.value(u) for u in places]) - kinked(places)
    assert np.abs(apart).max() < SHARE * min(abs(kinked(-10.0)), kinked(10.0))
    truths = {"dead_band_plus": 0.3, "dead_band_minus": -0.5, "null_offset": -0.1, "hysteresis": HYSTERESIS}
    for key, true in truths.items():
        assert found.numbers[key].value == pytest.approx(true, abs=OFF), key


@pytest.mark.slow  # many logs
@pytest.mark.parametrize(
    "measure",
    [
        lambda seed, one: sweep(seed, one.curve, width=one.width),
        lambda seed, one: sweep(seed, one.curve, width=one.width, lag=one.lag),
        lambda seed, one: stairs(seed, one.curve, width=one.width),
    ],
    ids=EXPERIMENTS,
)
def test_intervals_hold_the_truth_about_19_times_in_20(measure):
    """Of valves with a slope on either side of their dead band."""
    held, relative = {}, []
    for seed in range(40):
        valve = drawn_valve(seed)
        truths = {
            "dead_band_plus": valve.high,
            "dead_band_minus": valve.low,
            "dead_band": valve.high - valve.low,
            "null_offset": 0.5 * (valve.high + valve.low),
            "hysteresis": valve.width,
        }
        numbers = mapped(measure(seed, valve)).numbers
        for key in numbers.keys() & truths.keys():
            low, true, high = numbers[key].low, truths[key], numbers[key].high
            held.setdefault(key, []).append(low <= true <= high)
            relative.append((numbers[key].value - true) / (0.5 * (high - low) / 1.96))
    every = np.concatenate([*held.values()])
    assert every.size > 0.7 * 5 * 40  # others are said not to be determined
    assert every.mean() > 0.93
    assert min(np.mean(one) for one in held.values()) > 0.87  # 40 draws of 95 % hold fewer 3 times in 100
    assert np.std(relative) > 0.6  # 1 of intervals that are as wide as they must be


def test_a_null_beside_the_middle_is_met_where_it_is():
    found = mapped(sweep(0, lambda u: kinked(u - 2.0)))
    command, speed = curve_of(found)
    assert np.abs(speed - kinked(command - 2.0)).max() < SHARE * 0.4
    for key, true in {"dead_band_plus": 2.3, "dead_band_minus": 1.5, "null_offset": 1.9}.items():
        assert found.numbers[key].value == pytest.approx(true, abs=OFF), key
        assert found.numbers[key].low <= true <= found.numbers[key].high, key


def levels(*volts, cycles=4):
    """Stairs of these levels without noise, of a valve without hysteresis."""
    command = np.repeat(np.tile(np.array(volts, dtype=float), cycles), 100)
    return {"time": 0.01 * np.arange(command.size), "command": command, "velocity": kinked(command)}


def test_few_levels_tell_no_dead_band():
    found = mapped(levels(0, 5, 10, 5, 0, -5, -10, -5))
    for key in DEAD_BAND:
        assert key not in found.numbers
        assert found.undetermined[key].startswith("too few levels about null")
    command, speed = curve_of(found)
    assert command[speed == 0.0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("measure", [sweep, stairs])
@pytest.mark.parametrize("power", [1.5, 2, 3])
def test_a_curve_without_a_slope_at_null_tells_no_dead_band(measure, power):
    def flat(command):
        return 0.65 * np.sign(command) * (np.maximum(np.abs(command) - 0.5, 0.0) / 9.5) ** power

    found = mapped(measure(0, flat))
    assert not found.numbers.keys() & set(DEAD_BAND)
    assert "bends too much about null" in found.undetermined["dead_band"]
    command, speed = curve_of(found)
    assert np.abs(speed - flat(command)).max() < SHARE * 0.65


def test_a_position_tells_the_same_table_as_a_velocity():
    log = sweep(0)
    steps = np.diff(log["time"], prepend=-0.01) * np.append(0.0, log["velocity"][:-1])
    position = 1e-5 * np.round(np.cumsum(steps) / 1e-5)
    command, speed = curve_of(
        mapped({**{key: log[key] for key in ("time", "command")}, "position": position})
    )
    assert np.abs(speed - kinked(command)).max() < SHARE * 0.5


def test_the_dead_band_is_flat_and_points_are_denser_about_null_and_the_kinks():
    command, speed = curve_of(mapped(sweep(1)))
    (flat,) = np.nonzero(speed == 0.0)
    assert flat.size == 2
    assert np.diff(flat) == 1
    steps = np.diff(command)
    assert steps[flat[1] + 1] < 0.5 * steps[-3]
    about = steps[np.flatnonzero(command < 4.0)[-1]]
    assert about < 0.5 * steps[np.flatnonzero(command < 6.0)[-1]]


def test_each_point_says_how_sure_it_is():
    table = mapped(sweep(2)).characteristic
    half, deviation = table["speed_half"].values, table["speed_deviation"].values
    truth = kinked(table["command"].values)
    held = (
        np.abs(table["speed"].values - truth) <= half + 1e-3 * np.abs(truth).max()
    )  # a kink is between points
    assert held.mean() > 0.8
    noise = 0.01 * 0.65 / np.sqrt(3.0)  # three samples make one
    assert np.median(deviation) == pytest.approx(noise, rel=0.2)
    assert table["samples"].values.sum() > 3000
    widths = table["hysteresis"].values
    assert np.nanmedian(widths) == pytest.approx(HYSTERESIS, abs=0.03)


def test_without_a_dead_band_the_table_goes_through_null_in_one_point():
    found = mapped(sweep(0, straight, width=0.0))
    command, speed = curve_of(found)
    assert (speed == 0.0).sum() == 1
    assert command[speed == 0.0] == pytest.approx(0.0, abs=0.05)
    assert "dead_band" not in found.numbers
    assert "may be none" in found.undetermined["dead_band"]


def test_a_level_that_is_met_from_one_side_tells_no_hysteresis():
    levels = np.array([u for a in np.linspace(0.2, 9.8, 25) for u in (0.0, a, 0.0, -a)])
    command = np.repeat(levels, 100)
    time = 0.01 * np.arange(command.size)
    noise = np.random.default_rng(4).normal(scale=2e-3, size=time.size)
    found = mapped({"time": time, "command": command, "velocity": kinked(command) + noise})
    assert "hysteresis" not in found.numbers
    assert "from both sides" in found.undetermined["hysteresis"]
    command, speed = curve_of(found)
    assert np.abs(speed - kinked(command)).max() < SHARE * 0.5


def test_levels_that_do_not_settle_are_left_out():
    found = mapped(stairs(0, time_constant=0.5, rest=0.8))
    assert any("did not settle and are left out" in line for line in found.remarks)


def with_pressures(log):
    """The same with a chamber that stays at half of the machine's supply, but for noise."""
    noise = np.random.default_rng(9).normal(scale=1e4, size=(2, log["time"].size))
    return log | {"pressure_a": 61e5 + noise[0], "pressure_b": 61e5 + noise[1]}


def slow(log, factor):
    return log | {"velocity": factor * log["velocity"]}


def test_the_scenario_written_plays_the_table(tmp_path):
    """At half of the supply's drop over each edge the flow is A_A v, and a valve of edges passes it."""
    found = hs.map_logs("characteristic", with_pressures(sweep(0)), scenario("machine"))
    table = found.characteristic
    area = hs.load_scenario(scenario("machine")).plant.area_a
    at = table["command"].values
    full = area * kinked(10.0)
    assert np.abs(table["flow"].values - area * kinked(at)).max() < SHARE * full
    path = tmp_path / "played.toml"
    path.write_text(found.toml(tmp_path))
    loop = hs.load_scenario(path)
    valve, line = loop.valve, loop.supply.pressures(loop.supply.init())
    half = 0.5 * (line.supply + line.tank)
    passed = [valve.orifice.port_flows(valve.gain * u, line, half, half).a for u in at]
    assert np.abs(passed - table["flow"].values).max() < 1e-3 * full
    assert valve.hysteresis == pytest.approx(found.numbers["hysteresis"].value * valve.gain)


def test_a_speed_is_played_by_no_valve():
    found = hs.map_logs("characteristic", sweep(0), scenario("machine"))
    assert "speed" in found.characteristic
    assert found.tables == {}
    assert any("no pressure_a was measured" in line for line in found.remarks)
    assert any("the scenario's valve stays as it is" in line for line in found.remarks)


def test_no_valve_plays_a_table_of_one_sign_of_the_command():
    log = with_pressures(sweep(0))
    found = hs.map_logs("characteristic", log | {"command": 6.0 + 0.5 * log["command"]}, scenario("machine"))
    assert found.tables == {}
    assert any("has one sign of the command only" in line for line in found.remarks)


def test_a_regenerative_valve_keeps_its_edges():
    changes = {"valve.orifice.regeneration": True}
    found = hs.map_logs("characteristic", with_pressures(sweep(0)), scenario("machine"), changes=changes)
    assert "flow_curve" not in str(found.tables)
    assert any("a regenerative valve does not pass" in line for line in found.remarks)


def test_a_table_in_a_file_is_that_of_a_law(tmp_path):
    found = mapped(stairs(3))
    found.finding().files["characteristic.csv"](tmp_path / "characteristic.csv")
    inner = {"type": "PID", "proportional_gain": "200 V/m", "integral_gain": "0 V/(m s)"}
    law = {
        "type": "CharacteristicCompensation.from_speed",
        "speed": {"file": str(tmp_path / "characteristic.csv")},
        "full_command": "10 V",
        "threshold": "0.1 V",
        "controller": inner,
    }
    read = hs.load_scenario("axis/position", {"controller": law}).controller
    made = CharacteristicCompensation.from_speed(
        PID(200.0, 0.0), Curve.from_samples(*curve_of(found)), 10.0, 0.1
    )
    np.testing.assert_array_equal(read.inverse.knots, made.inverse.knots)
    wishes = np.linspace(-7.0, 10.0, 50)
    speeds = np.array([kinked(read.inverse.value(one)) for one in wishes if abs(one) > 0.2])
    straight_line = np.array([0.065 * one for one in wishes if abs(one) > 0.2])
    np.testing.assert_allclose(speeds, straight_line, atol=0.01)


@pytest.mark.parametrize(
    ("log", "machine", "said"),
    [
        (
            sweep(0) | {"command": np.full(12000, 0.5)},
            None,
            "command: is 500 mV throughout: it must rise and fall",
        ),
        (sweep(0, period=1.0, lag=0.15), None, "command: rises and falls"),
        (sweep(0, period=4.0, lag=0.12), None, "command: rises and falls"),
        (sweep(0, period=4.0, lag=0.06), None, "command: the sweep is too fast: at 11.2 V/s a lag of"),
        (sweep(0, cycles=0.25), None, "command: has a sweep one way only"),
        (sweep(0, lambda u: np.maximum(kinked(u), 0.0)), None, "command: shows no negative speed"),
        (sweep(0, lambda u: 1e-9 * u), None, "command: shows no"),
        (
            {key: one for key, one in sweep(0).items() if key != "velocity"} | {"force": np.arange(12000.0)},
            None,
            'no column "velocity [m/s]" or "position [m]"',
        ),
        (levels(-5, 5), None, "command: has one level beyond null on a side: add some"),
        (levels(-5, 0, 5, 0), None, "command: has one level beyond null on a side: add some"),
        (slow(with_pressures(sweep(0)), 1e3), "machine", "is its unit right?"),
        (slow(with_pressures(sweep(0)), 1e-3), "machine", "is its unit right?"),
    ],
)
def test_a_log_that_makes_no_table_is_refused_in_one_line(log, machine, said):
    with pytest.raises(ScenarioError) as caught:
        hs.map_logs("characteristic", log, machine and scenario(machine))
    assert said in str(caught.value)
    assert "log 1" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_bent_valve_is_no_straight_line():
    def steep(command):
        return 1e-3 * command + 0.3 * np.sign(command) * np.maximum(np.abs(command) - 9.7, 0.0)

    with pytest.raises(ScenarioError, match=r"flow is bent, .* map characteristic measures a bent one"):
        hs.map_logs("valve-flow", sweep(0, steep), scenario("machine"))


@pytest.mark.parametrize(
    ("rows", "said"),
    [("-1,-2\n0,0.2\n1,0.1\n", "falls from 0 to 1 V"), ("1,2\n", "has 1 rows of numbers; at least 2")],
)
def test_a_wrong_table_in_a_scenario_is_refused_with_its_file_or_key(rows, said, tmp_path):
    (tmp_path / "table.csv").write_text(f"command [V],speed [m/s]\n{rows}")
    path = tmp_path / "law.toml"
    path.write_text(
        'base = "axis/position"\n[controller]\ntype = "CharacteristicCompensation.from_speed"\n'
        'speed = { file = "table.csv" }\nfull_command = "10 V"\nthreshold = "0.1 V"\n'
        'controller = { type = "PID", proportional_gain = "200 V/m", integral_gain = "0 V/(m s)" }\n'
    )
    with pytest.raises(ScenarioError, match=said) as caught:
        hs.load_scenario(path)
    assert "law.toml: controller" in str(caught.value) or "table.csv" in str(caught.value)
