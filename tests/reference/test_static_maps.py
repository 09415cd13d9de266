"""Maps of simulated logs, with noise and quantisation, give back the machine; of a real one, its page."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import hydroservo as hs
from hydroservo.core.curve import Curve
from tests.support.map_logs import scenario, seen
from tests.support.tiers import mostly

SEEDS = range(3)
ROOT = Path(__file__).parents[2]
BENCH = hs.load_scenario(scenario("machine"))
ACCURACY = {
    "valve-flow": 0.015,
    "pressure-gain": 0.02,
    "friction": 0.03,
    "decay": 5e-3,
}  # of systematic errors
WIDTH = 2e-3  # that of a hysteresis, once the lag of valve and sampling is taken off


def near(one, true, share, about=None):
    """Whether a number and its interval say the truth, but for a systematic error of that share of it."""
    allowed = share * abs(true if about is None else about)
    return one.low - allowed <= true <= one.high + allowed and abs(one.value - true) < 2.0 * allowed


def load_flow(loop, opening):
    """Merritt's flow of sharp edges without load, at the supply's drop."""
    edges, drop = loop.valve.orifice, loop.supply.drop()
    return edges.discharge_coefficient * edges.area_gradient * opening * np.sqrt(drop / edges.density)


@pytest.mark.slow
@pytest.mark.parametrize("seed", mostly(pytest.mark.nightly, SEEDS, [0]))
def test_a_sweep_gives_back_the_valve(seed):
    found = hs.map_logs("valve-flow", seen("valve_flow", seed), scenario("valve_flow"))
    gain = load_flow(BENCH, BENCH.valve.gain)
    lap = BENCH.valve.orifice.lap / BENCH.valve.gain
    share = ACCURACY["valve-flow"]
    for way, sign in (("plus", 1.0), ("minus", -1.0)):
        assert near(found.numbers[f"flow_gain_{way}"], gain, share)
        assert near(found.numbers[f"dead_band_{way}"], sign * lap, share)
    assert near(found.numbers["hysteresis"], BENCH.valve.hysteresis / BENCH.valve.gain, WIDTH)
    assert near(found.numbers["null_offset"], 0.0, share, lap)


def seen_table(seed):
    """The table of the example's stairs, with the scenario's loop."""
    found = hs.map_logs("characteristic", seen("characteristic", seed), scenario("characteristic"))
    table = found.characteristic
    return table["command"].values, table["flow"].values, found.loop


@pytest.mark.slow
@pytest.mark.parametrize("seed", mostly(pytest.mark.nightly, SEEDS, [0]))
def test_stairs_give_back_the_curve_of_a_valve_with_a_kink(seed):
    command, flow, loop = seen_table(seed)
    valve, drop = loop.valve, loop.supply.drop()
    places = np.linspace(command[0], command[-1], 1001)
    true = np.array([valve.orifice.flow(valve.gain * u, drop, 0.0) for u in places])
    measured = Curve.from_samples(command, flow)
    apart = np.array([measured.value(u) for u in places]) - true
    assert np.abs(apart).max() < 0.01 * np.abs(true).max()


@pytest.mark.slow
def test_a_loop_is_better_with_the_measured_table_than_with_the_overlap_alone():
    """With the same gains for all; docs/controllers/industry.md searches those of each."""
    command, flow, loop = seen_table(0)
    curve = {"points": [[f"{u} V", f"{q} m^3/s"] for u, q in zip(command, flow, strict=True)]}
    pid = {
        "type": "PID",
        "proportional_gain": "1434 V/m",
        "integral_gain": "1365 V/(m s)",
        "rate_feedforward": "30 V s/m",
    }
    laws = {
        "none": pid,
        "overlap": {
            "type": "DeadBandCompensation",
            "extend_overlap": "0.3 V",
            "retract_overlap": "0.3 V",
            "threshold": "0.14 V",
            "controller": pid,
        },
        "measured": {
            "type": "CharacteristicCompensation.from_flow",
            "flow": curve,
            "full_command": "10 V",
            "threshold": "0.14 V",
            "controller": pid,
        },
    }
    errors = {}
    for name, law in laws.items():
        axis = hs.load_scenario("axis/position", {"controller": law})
        errors[name] = float(hs.simulate(axis._replace(valve=loop.valve))["rms_error"])
    assert errors["measured"] < 0.7 * errors["overlap"] < 0.7 * errors["none"]


def blocked_gain(loop):
    """Mean slope of the load pressure of blocked ports within 40 % of the supply's drop [Pa/V]."""
    edges, valve = loop.valve.orifice, loop.valve
    line = loop.supply.pressures(loop.supply.init())

    def load(x):
        a = brentq(lambda p: edges.port_flows(x, line, p, p).a, line.tank, line.supply)
        b = brentq(lambda p: edges.port_flows(x, line, p, p).b, line.tank, line.supply)
        return a - b

    end = brentq(lambda x: load(x) - 0.4 * loop.supply.drop(), 0.0, valve.max_opening)
    openings = np.linspace(-end, end, 81)
    return valve.gain * np.polyfit(openings, [load(x) for x in openings], 1)[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", mostly(pytest.mark.nightly, SEEDS, [0]))
def test_a_sweep_with_blocked_ports_gives_back_the_pressure_gain(seed):
    found = hs.map_logs("pressure-gain", seen("pressure_gain", seed), scenario("pressure_gain"))
    loop = hs.load_scenario(scenario("pressure_gain"))
    assert near(found.numbers["pressure_gain"], blocked_gain(loop), ACCURACY["pressure-gain"])
    assert near(found.numbers["hysteresis"], loop.valve.hysteresis / loop.valve.gain, WIDTH)
    assert abs(found.numbers["null_offset"].value) < 2e-4
    clearance = found.tables["truth"]["valve"]["orifice"]["clearance"]
    assert clearance == pytest.approx(loop.valve.orifice.clearance, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("seed", mostly(pytest.mark.nightly, SEEDS, [0]))
def test_moves_give_back_friction(seed):
    found = hs.map_logs("friction", seen("friction", seed), scenario("friction"))
    true = BENCH.plant.friction
    for name in ("coulomb", "breakaway", "stribeck_velocity", "viscous"):
        assert near(found.numbers[name], getattr(true, name), ACCURACY["friction"]), name
    assert abs(found.numbers["offset"].value) < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", mostly(pytest.mark.nightly, SEEDS, [0]))
@pytest.mark.parametrize("name", ["decay", "compression"])
def test_pressures_behind_blocked_ports_give_back_leakage_and_bulk_modulus(name, seed):
    found = hs.map_logs("decay", seen(name, seed), scenario(name))
    plant = BENCH.plant
    share = ACCURACY["decay"]
    assert near(found.numbers["internal_leakage"], plant.internal_leakage, share)
    assert near(found.numbers["external_leakage"], plant.external_leakage, share)
    assert near(found.numbers["bulk_modulus"], plant.oil.effective_bulk_modulus, share)
    assert ("by a motion" in found.numbers["bulk_modulus"].meaning) == (name == "compression")


def bench():
    path = ROOT / "scripts" / "bench_logs.py"
    spec = importlib.util.spec_from_file_location("bench_logs", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_friction_of_a_real_bench_is_that_of_its_page():
    """The map of moves at constant speed, beside that of all samples that docs/bench.md shows."""
    page = bench()
    log = page.logs()[0]
    fitted = page.fitted(log).friction
    force = log["force"] - page.AREA * page.drop(log) - page.springs(log) @ fitted.besides
    given = {"time": log["time"], "velocity": log["velocity"], "hydraulic_force": force}
    found = hs.map_logs("friction", given)
    v, map_at = found.curve["velocity"].values, found.curve["friction"].values
    moves = np.abs(v) >= page.SPEEDS[0]
    assert moves.sum() >= 8
    apart = map_at[moves] - fitted.at(v[moves])
    assert np.sqrt(np.mean(apart**2)) < page.errors(page.fitted(log), log)["force"]
