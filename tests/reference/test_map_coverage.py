"""Maps of logs of an independent simulator: their intervals hold the truth, and wrong logs are refused."""

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.errors import ScenarioError
from tests.support.bench_simulator import Bench, case, closed, moved, seen, triangle
from tests.support.map_logs import scenario

LOGS = 8
HELD = 7  # of them, that each interval of 95 % must hold


def mapped(kind, log):
    return hs.map_logs(kind, log, scenario(kind.replace("-", "_")))


@pytest.mark.nightly  # many logs each
@pytest.mark.parametrize(
    ("kind", "left_out"),
    [(kind, ()) for kind in ("valve-flow", "pressure-gain", "friction", "decay")]
    + [("valve-flow", ("velocity",))],
)
def test_intervals_hold_the_truth_and_no_bias_is_as_wide(kind, left_out):
    errors = {}
    for seed in range(LOGS):
        one = case(kind, seed)
        measured = [name for name in one.measured if name not in left_out]
        found = mapped(kind, seen(one.exact, seed, *measured))
        for name, true in one.truth.items():
            number = found.numbers[name]
            row = number.value - true, 0.5 * (number.high - number.low), number.low <= true <= number.high
            errors.setdefault(name, []).append(row)
    for name, rows in errors.items():
        error, half, held = np.mean(rows, axis=0)
        assert held * LOGS >= HELD, name
        assert abs(error) < half, name


@pytest.mark.nightly  # many logs each
@pytest.mark.parametrize("lasts", [5.0, 40.0])
def test_an_offset_of_a_sensor_is_an_unknown_of_a_long_decay(lasts):
    held = []
    for seed in range(LOGS):
        offsets = np.random.default_rng(seed).uniform(-3e5, 3e5, 2)
        found = mapped("decay", decayed(seed, lasts, *offsets))
        leak, apart = found.numbers["internal_leakage"], found.numbers["pressure_offset"]
        held.append(
            (leak.low <= Bench().inside <= leak.high, apart.low <= offsets[0] - offsets[1] <= apart.high)
        )
    assert (np.sum(held, axis=0) >= HELD).all()


def decayed(seed=0, lasts=10.0, more_a=0.0, more_b=0.0):
    exact = closed(Bench(), np.linspace(0.0, lasts, 2001), (110e5, 15e5))
    log = seen(exact, seed, "pressure_a", "pressure_b")
    return log | {"pressure_a": log["pressure_a"] + more_a, "pressure_b": log["pressure_b"] + more_b}


def swept(rate, wave=np.sin, **changes):
    """A sweep of a quick machine, of two periods or 3 s."""
    bench = Bench()._replace(mass=20.0, coulomb=30.0, breakaway=40.0, **changes)
    time = np.arange(0.0, max(2.0 / rate, 3.0), 2e-3)
    command = triangle(time, 1.0, rate) if wave is triangle else np.sin(2.0 * np.pi * rate * time)
    return seen(moved(bench, time, command, 0.15), 0, "command", "position", "pressure_a", "pressure_b")


@pytest.fixture(scope="module")
def sweep():
    return swept(0.2)


def exchanged(log):
    return log | {"pressure_a": log["pressure_b"], "pressure_b": log["pressure_a"]}


@pytest.mark.parametrize("kind", ["valve-flow", "friction"])
@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (exchanged, "pressure_a and pressure_b are swapped"),
        (lambda log: log | {"position": 0.4 - log["position"]}, "position is reversed"),
    ],
)
def test_a_wrong_log_of_a_sweep_is_refused_with_its_cause(sweep, kind, fault, cause):
    with pytest.raises(ScenarioError, match=f"log 1: {cause}") as caught:
        mapped(kind, fault(sweep))
    assert "\n" not in str(caught.value)


def test_a_command_of_the_wrong_sign_is_refused(sweep):
    with pytest.raises(ScenarioError, match="command is reversed: the piston goes in as the command rises"):
        mapped("valve-flow", sweep | {"command": -sweep["command"]})


def test_pressures_that_fall_with_the_command_are_refused():
    time = np.arange(0.0, 40.0, 5e-3)
    command = 0.1 * np.sin(2.0 * np.pi * 0.05 * time)
    apart = 55e5 * np.tanh(-command / 0.01) + 1e3 * np.cos(99.0 * time)
    log = {"time": time, "command": command, "pressure_a": 60e5 + apart, "pressure_b": 60e5 - apart}
    with pytest.raises(ScenarioError, match="pressure_a and pressure_b are swapped, or command is reversed"):
        mapped("pressure-gain", log)


def test_a_quick_sweep_of_a_slow_valve_is_refused():
    with pytest.raises(ScenarioError, match="the sweep is too fast"):
        mapped("valve-flow", swept(1.0, frequency=5.0))


def test_the_lag_of_a_slow_valve_is_no_hysteresis():
    found = mapped("valve-flow", swept(0.2, frequency=5.0))
    assert "hysteresis" not in found.numbers
    assert "a lag of 5" in found.undetermined["hysteresis"]
    assert found.numbers["dead_band"].low < 0.8 < found.numbers["dead_band"].high


def test_one_rate_of_a_sweep_is_said():
    found = mapped("valve-flow", swept(0.2, triangle))
    assert any("the command has one rate" in line for line in found.remarks)


def test_an_offset_of_3_bar_is_seen_in_a_decay():
    found = mapped("decay", decayed(more_a=3e5))
    leak, offset = found.numbers["internal_leakage"], found.numbers["pressure_offset"]
    assert leak.low < Bench().inside < leak.high
    assert leak.high - leak.low < 0.05 * Bench().inside
    assert offset.value == pytest.approx(3e5, abs=2e3)


def test_a_short_decay_says_what_an_offset_does_to_it():
    found = mapped("decay", decayed(lasts=0.2))
    assert "pressure_offset" not in found.numbers
    assert any("too short to tell an offset" in line for line in found.remarks)


def test_a_decay_whose_volumes_are_exchanged_is_refused():
    with pytest.raises(ScenarioError, match="better with pressure_a and pressure_b exchanged"):
        mapped("decay", exchanged(decayed()))


def test_lines_that_cross_leave_no_dead_band():
    log = swept(0.2, triangle, dead_band=-0.1)
    found = mapped("valve-flow", log)
    assert "dead_band" not in found.numbers
    assert "underlapped" in found.undetermined["dead_band"]
    assert "cannot be determined" in repr(found)
