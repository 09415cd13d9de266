"""Spools with notches, one that feeds the rod side's oil back, and a scheduled gain, against scipy."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from hydroservo import Loop, load_scenario, simulate
from tests.support.axes import commanded_axis, step, viscous

L_MIN = 1.0 / 6e4  # m^3/s
SHARES = np.linspace(0.0, 1.0, 11)
FLOWS = np.array([0.0, 0.4, 1.2, 2.4, 4.0, 7.0, 12.0, 19.0, 28.0, 38.0, 50.0]) * L_MIN  # at 5 bar an edge
BULK, LAG, BEGIN, TRANSITION = 12e8, 0.01, 0.1, 1e3
RATED = {
    "type": "FourEdges.rated",
    "rated_flow": "auto",
    "rated_drop": "10 bar",
    "rated_opening": "1 mm",
    "transition_drop": TRANSITION,
}
SYMMETRIC = {
    "type": "Cylinder",
    "area_a": 1e-3,
    "area_b": 1e-3,
    "stroke": 2.0,
    "dead_volume_a": 2e-5,
    "dead_volume_b": 2e-5,
    "start_position": 0.9,
    "mechanism": {"type": "Mass", "mass": 20.0},
    "oil": {"type": "ConstantOil", "effective_bulk_modulus": BULK},
}
SINGLE_ROD = SYMMETRIC | {
    "area_a": np.pi / 4 * 0.063**2,
    "area_b": np.pi / 4 * (0.063**2 - 0.045**2),
    "stroke": 0.8,
    "start_position": 0.1,
    "mechanism": {"type": "Mass", "mass": 150.0},
    "friction": viscous("500 N s/m"),
}
Conductances = Callable[[float], tuple[float, float, float, float]]  # of P-A, A-T, P-B, B-T over u/10 V


def curve(x: Any, y: Any) -> dict[str, object]:
    """The table of a curve."""
    return {"points": [[float(a), float(b)] for a, b in zip(x, y, strict=True)]}


def duration(command: float) -> float:
    """How long a run is: until it is settled, or nearly at the end of the stroke [s]."""
    return 0.3 if abs(command) == 10.0 else 1.1


def axis(command: float, supply: float, plant: dict[str, object], edges: dict[str, object]) -> Loop:
    """An axis on a valve with a lag, whose command is a step."""
    return commanded_axis(
        {
            "simulation": {"duration": duration(command), "period": "1 ms", "substeps": "auto"},
            "reference": step("0 V", f"{command} V", f"{BEGIN} s"),
            "supply": {"type": "IdealSupply", "supply_pressure": supply},
            "load": {"type": "Constant", "amplitude": 2000.0 if plant is SINGLE_ROD else 0.0},
            "plant": plant,
            "valve": {
                "type": "FirstOrderValve",
                "time_constant": LAG,
                "gain": "0.1 mm/V",
                "max_opening": "1 mm",
                "orifice": edges,
            },
        }
    )


def root(drop: float) -> float:
    return drop / (drop * drop + TRANSITION * TRANSITION) ** 0.25


def integrated(loop: Loop, command: float, opened: Conductances, b_to_supply: bool = False) -> np.ndarray:
    """Velocity, position and both pressures at the run's end, from where the run is when the step comes."""
    run, plant, supply = simulate(loop), loop.plant, loop.supply.supply_pressure
    names = ("velocity", "position", "pressure_a", "pressure_b")
    columns = [run[f"plant.{name}"] for name in names]
    begun = [float(one.sel(time=BEGIN)) for one in columns]

    def rates(t: float, state: np.ndarray) -> list[float]:
        v, x, a, b = state
        pa, at, pb, bt = opened(0.1 * command * (1.0 - np.exp(-t / LAG)))
        into_a = pa * root(supply - a) - at * root(a)
        out_of_b = bt * root(b - (supply if b_to_supply else 0.0)) - pb * root(supply - b)
        volume_a = plant.dead_volume_a + plant.area_a * x
        volume_b = plant.dead_volume_b + plant.area_b * (plant.stroke - x)
        force = plant.area_a * a - plant.area_b * b - loop.load.amplitude - plant.friction.coefficient * v
        flow_a, flow_b = into_a - plant.area_a * v, plant.area_b * v - out_of_b
        return [force / plant.mechanism.mass, v, BULK / volume_a * flow_a, BULK / volume_b * flow_b]

    scale = np.array([1e-3, 1e-3, 1e4, 1e4])
    found = solve_ivp(
        rates, (0.0, duration(command) - BEGIN), begun, method="DOP853", rtol=1e-10, atol=1e-8 * scale
    )
    ended = np.array([float(one[-1]) for one in columns])
    np.testing.assert_allclose(ended, found.y[:, -1], rtol=2e-5, atol=1e-9)
    return found.y[:, -1]


def straight(x: float) -> tuple[float, float, float, float]:
    forth, back = max(x, 0.0), max(-x, 0.0)
    return forth, back, back, forth


def by(table: Any, below: Any = None) -> Conductances:
    """The conductances of four edges of one curve, or of one in each direction."""

    def opened(x: float) -> tuple[float, float, float, float]:
        forth = float(table(max(x, 0.0))) / root(5e5)
        back = float((below or table)(max(-x, 0.0))) / root(5e5)
        return forth, back, back, forth

    return opened


@pytest.mark.parametrize(("command", "velocity"), [(2.0, 0.0632), (5.0, 0.369), (10.0, 2.635)])
def test_a_progressive_spool_passes_the_flow_of_its_curve(command: float, velocity: float) -> None:
    for sign in (1.0, -1.0):
        loop = axis(sign * command, 100e5, SYMMETRIC, RATED | {"flow_curve": curve(SHARES, FLOWS)})
        end = integrated(loop, sign * command, by(PchipInterpolator(SHARES, FLOWS)))
        if command < 10.0:  # else it is not settled, or at the end of its stroke
            assert sign * end[0] == pytest.approx(velocity, rel=5e-3)
            assert velocity == pytest.approx(FLOWS[int(command)] * 10.0**0.5 / 1e-3, rel=2e-3)


def test_between_two_points_it_passes_what_the_monotone_cubic_has() -> None:
    shares, flows = [0.0, 0.2, 0.4, 1.0], [0.0, 0.0, 5.0 * L_MIN, 40.0 * L_MIN]
    table = PchipInterpolator(shares, flows)
    for command in (1.5, 3.0, -4.5):  # within the overlap, and beyond it
        loop = axis(command, 100e5, SYMMETRIC, RATED | {"flow_curve": curve(shares, flows)})
        end = integrated(loop, command, by(table))
        assert abs(end[0]) == pytest.approx(
            float(table(0.1 * abs(command))) * 10.0**0.5 / 1e-3, rel=2e-3, abs=1e-9
        )


@pytest.mark.parametrize("sizes", [False, True])
def test_the_two_directions_may_differ(sizes: bool) -> None:
    shares = [-1.0, -0.5, 0.0, 0.5, 1.0]
    flows = np.array([-30.0, -12.0, 0.0, 7.0, 50.0]) * L_MIN
    given = np.abs(flows) if sizes else flows
    table = PchipInterpolator(shares, flows)
    for command in (5.0, -5.0):
        loop = axis(command, 100e5, SYMMETRIC, RATED | {"flow_curve": curve(shares, given)})
        end = integrated(loop, command, by(table, lambda x: -table(-x)))
        assert end[0] == pytest.approx(float(table(0.1 * command)) * 10.0**0.5 / 1e-3, rel=2e-3)


def test_an_edge_may_have_a_curve_of_its_own() -> None:
    other = FLOWS**0.5 * FLOWS[-1] ** 0.5
    edges = RATED | {"flow_curve": curve(SHARES, FLOWS), "flow_curve_bt": curve(SHARES, other)}
    one, two = by(PchipInterpolator(SHARES, FLOWS)), by(PchipInterpolator(SHARES, other))
    for command in (5.0, -5.0):
        loop = axis(command, 100e5, SYMMETRIC, edges)
        integrated(loop, command, lambda x: (*one(x)[:3], two(x)[3]))


def test_areas_pass_what_the_root_law_says() -> None:
    openings, areas = [0.0, 0.5e-3, 1e-3], [0.0, 2e-6, 12e-6]
    edges = {
        "type": "FourEdges.from_areas",
        "discharge_coefficient": 0.7,
        "density": 860.0,
        "clearance": 0.0,
        "transition_drop": TRANSITION,
        "area_curve": {"points": [["0 mm", "0 mm^2"], ["0.5 mm", "2 mm^2"], ["1 mm", "12 mm^2"]]},
    }
    table = PchipInterpolator(openings, areas)
    per_area = 0.7 * (2.0 / 860.0) ** 0.5

    def opened(x: float) -> tuple[float, float, float, float]:
        forth, back = straight(x)[:2]
        forth, back = (per_area * float(table(1e-3 * one)) for one in (forth, back))
        return forth, back, back, forth

    end = integrated(axis(5.0, 100e5, SYMMETRIC, edges), 5.0, opened)
    assert end[0] == pytest.approx(per_area * 2e-6 * 50e5**0.5 / 1e-3, rel=1e-4)


def test_a_spool_that_feeds_the_rod_side_back() -> None:
    edges = RATED | {"rated_flow": "40 L/min", "rated_drop": "70 bar", "regeneration": True}
    loop = axis(10.0, 140e5, SINGLE_ROD, edges)
    per = 40.0 * L_MIN / root(35e5)
    end = integrated(loop, 10.0, lambda x: tuple(per * one for one in straight(x)), b_to_supply=True)  # type: ignore[return-value]
    a, b = loop.plant.area_a, loop.plant.area_b

    def unbalanced(v: float) -> float:
        lost_a, lost_b = ((area * v / per) ** 2 for area in (a, b))
        return a * (140e5 - lost_a) - b * (140e5 + lost_b) - 500.0 * v - 2000.0

    v = float(brentq(unbalanced, 0.0, 1.0))
    assert v == pytest.approx(0.27479, rel=1e-4)
    right = [v, 140e5 - (a * v / per) ** 2, 140e5 + (b * v / per) ** 2]
    assert [end[0], *end[2:]] == pytest.approx(right, rel=1e-4)
    flows = loop.valve.orifice.port_flows(1e-3, loop.supply.pressures(loop.supply.init()), *end[2:])
    assert flows.supply == pytest.approx((a - b) * v, rel=1e-4) == 26.22 * L_MIN
    assert flows.tank == 0.0


def test_a_regenerating_spool_retracts_as_any_other() -> None:
    edges = RATED | {"rated_flow": "40 L/min", "rated_drop": "70 bar"}
    plant = SINGLE_ROD | {"start_position": 0.7}
    runs = [
        simulate(axis(-5.0, 140e5, plant, edges | {"regeneration": one}))["plant.velocity"]
        for one in (True, False)
    ]
    assert float(runs[0][-1]) == pytest.approx(float(runs[1][-1]), rel=1e-12)


LAW = '''
from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.control.controllers import Saturation
from hydroservo.core.curve import Curve
from hydroservo.core.roles import Controller, role


class ScheduledState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


@role(Controller)
class ScheduledGain(NamedTuple):
    """u = k(|v|) e."""

    curve: Annotated[Curve, Field("V/m", "gain", over="m/s")]
    saturation: Saturation = Saturation()

    def init(self):
        return ScheduledState(0.0)

    def step(self, s, y, r, dt):
        gain = self.curve.value(ops.absolute(y.velocity))
        return ScheduledState(self.saturation.apply(gain * (r.value - y.position)))
'''


def test_a_gain_over_the_speed(tmp_path: Path) -> None:
    law, table = tmp_path / "scheduled.py", tmp_path / "gain.csv"
    law.write_text(LAW)
    table.write_text("v [mm/s],k [V/m]\n0,130\n40,95\n100,70\n250,55\n")
    scenario = tmp_path / "axis.toml"
    scenario.write_text(f"""
simulation = {{ duration = "0.2 s", period = "1 ms", substeps = "auto" }}
supply = {{ type = "IdealSupply", supply_pressure = "150 bar" }}
controls = {{ type = "Position" }}
reference = {{ type = "Step", initial = "120 mm", final = "135 mm", time = "40 ms" }}
controller = {{ type = "ScheduledGain", curve = {{ file = "{table.name}" }} }}

[plant]
type = "Cylinder.from_diameters"
bore = "50 mm"
rod = "32 mm"
stroke = "300 mm"
start_position = "120 mm"
mechanism = {{ type = "Mass", mass = "140 kg" }}
oil = {{ type = "ConstantOil", effective_bulk_modulus = "10000 bar" }}
friction = {{ type = "Viscous", coefficient = "900 N s/m" }}

[valve]
type = "FirstOrderValve"
time_constant = "5 ms"
gain = "0.1 mm/V"
max_opening = "1 mm"
[valve.orifice]
type = "FourEdges.rated"
rated_flow = "24 L/min"
rated_drop = "70 bar"
rated_opening = "1 mm"
""")
    loop = load_scenario(scenario, plugins=[law])
    run = simulate(loop)
    gain = PchipInterpolator([0.0, 0.04, 0.1, 0.25], [130.0, 95.0, 70.0, 55.0])
    plant, per = loop.plant, 24.0 * L_MIN / 1e-3 / 35e5**0.5
    state = np.array([float(run[name][0]) for name in ("plant.velocity", "plant.position")])
    state = np.array([*state, *(float(run[f"plant.pressure_{one}"][0]) for one in "ab"), 0.0])

    def rates(_: float, numbers: np.ndarray, u: float) -> list[float]:
        v, x, a, b, spool = numbers
        forth, back = per * max(spool, 0.0), per * max(-spool, 0.0)
        into_a = forth * smooth(150e5 - a) - back * smooth(a)
        out_of_b = forth * smooth(b) - back * smooth(150e5 - b)
        force = plant.area_a * a - plant.area_b * b - 900.0 * v
        volume_a = plant.dead_volume_a + plant.area_a * x
        volume_b = plant.dead_volume_b + plant.area_b * (0.3 - x)
        pressed = 1e9 / volume_a * (into_a - plant.area_a * v), 1e9 / volume_b * (plant.area_b * v - out_of_b)
        return [force / 140.0, v, *pressed, (1e-4 * u - spool) / 5e-3]

    def smooth(drop: float) -> float:
        return drop / (drop * drop + 1e5**2) ** 0.25

    positions = [state[1]]
    for k in range(200):
        u = float(gain(abs(state[0]))) * ((0.135 if k >= 40 else 0.12) - state[1])
        state = solve_ivp(
            rates, (0.0, 1e-3), state, method="DOP853", rtol=1e-9, atol=1e-10, args=(np.clip(u, -10.0, 10.0),)
        ).y[:, -1]
        positions.append(state[1])
    assert positions[100] == pytest.approx(122.959e-3, rel=1e-5)
    found = [float(run["plant.position"].sel(time=t)) for t in (0.05, 0.1, 0.15)]
    assert found == pytest.approx([positions[k] for k in (50, 100, 150)], rel=1e-5)
