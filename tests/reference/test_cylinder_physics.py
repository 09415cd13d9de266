"""The cylinder with two chambers: oil, energy, frequencies, limits; by scipy at tight tolerance."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo.core.block import Block
from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.machine.drives import open_ports
from hydroservo.machine.mechanics import Mass, NoStops, OneLinkArm, Stops, Viscous, ViscousState
from hydroservo.machine.oils import AeratedOil, ConstantOil
from hydroservo.machine.plants import Cylinder, CylinderState, LoadPressurePlant, LoadPressureState
from hydroservo.machine.valves import Orifice
from hydroservo.testing.examples import example

ATMOSPHERE = 101325.0
CLOSED = PortFlows(0.0, 0.0, 0.0, 0.0)
LEAKY = example(
    Cylinder,
    area_a=8e-4,
    area_b=5e-4,
    internal_leakage=2e-11,
    external_leakage=1e-12,
    friction=Viscous(200.0),
    stops=NoStops(),
    mechanism=example(OneLinkArm),
)
Flows = Callable[[float], PortFlows]


def rates_of(plant: Cylinder, y: np.ndarray, flows: PortFlows, force: float = 0.0) -> list[float]:
    """Rates of velocity, position and the two pressures, with a friction that remembers nothing."""
    rate = plant.deriv(CylinderState(*y[:4].tolist(), ViscousState()), flows, force)
    return list(rate[:4])


def solved(rates: Callable[..., Any], start: list[float], duration: float, **options: Any) -> Any:
    done = solve_ivp(rates, (0.0, duration), start, "DOP853", rtol=1e-12, **options)
    assert done.success
    return done


def pumped(t: float) -> PortFlows:
    """Some flows, in and out by turns."""
    return PortFlows(4e-5 * math.sin(40.0 * t), 2.5e-5 * math.sin(40.0 * t + 0.02), 0.0, 0.0)


def constant_density(oil: ConstantOil, pressure: float) -> float:
    return math.exp(pressure / oil.effective_bulk_modulus)


def aerated_density(oil: AeratedOil, pressure: float) -> float:
    liquid = (1.0 - oil.air_content) / (1.0 + pressure / oil.liquid_bulk_modulus)
    gas = oil.air_content * (ATMOSPHERE / (pressure + ATMOSPHERE)) ** (1.0 / oil.polytropic_index)
    return 1.0 / (liquid + gas)


@pytest.mark.parametrize(
    ("oil", "density"),
    [(example(ConstantOil), constant_density), (AeratedOil(1.4e9, 0.01, 1.3), aerated_density)],
)
def test_oil_is_conserved(oil: Block, density: Callable[[Block, float], float]) -> None:
    """Each chamber's rho V changes by the integral of rho times what flows in; rho from the volume law."""
    plant = LEAKY._replace(oil=oil)

    def net(y: np.ndarray, flows: PortFlows) -> tuple[float, float]:
        past = 2e-11 * (y[2] - y[3])
        return flows.a - past - 1e-12 * y[2], past - flows.b - 1e-12 * y[3]

    def rates(t: float, y: np.ndarray) -> list[float]:
        into = net(y, pumped(t))
        grown = [density(oil, p) * q for p, q in zip(y[2:4], into, strict=True)]
        return rates_of(plant, y, pumped(t), 200.0) + grown

    start = [0.0, 0.039, 30e5, 38e5, 0.0, 0.0]
    y = solved(rates, start, 0.3, atol=[1e-12, 1e-13, 1e-5, 1e-5, 1e-17, 1e-17]).y
    volumes = (plant.dead_volume_a + 8e-4 * y[1], plant.dead_volume_b + 5e-4 * (0.078 - y[1]))
    assert y[2:4].min() > 0.0
    assert np.ptp(y[2]) > 1e5
    assert np.ptp(y[1]) > 1e-3
    for pressure, volume, grown in zip(y[2:4], volumes, y[4:6], strict=True):
        mass = np.array([density(oil, p) for p in pressure]) * volume
        assert mass - mass[0] == pytest.approx(grown, rel=1e-9, abs=1e-10 * mass[0])
        assert np.abs(grown).max() > 1e-2 * mass[0]


def test_energy_is_accounted_for() -> None:
    """What the valve and the load bring goes into motion, height, oil, friction and leaks, to 1e-9 of it.

    The oil of one bulk modulus has e = int p/(rho beta) dp, so that rho e = beta (e^(p/beta) - 1 - p/beta);
    oil that enters brings p + rho e per volume. Height and speed of the arm come from its angle.
    """
    plant, beta = LEAKY, 7e8
    arm = plant.mechanism
    assert isinstance(arm, OneLinkArm)

    def stored_in_oil(p: float) -> float:
        return beta * (math.expm1(p / beta) - p / beta)

    def powers(t: float, y: np.ndarray) -> list[float]:
        v, _, p_a, p_b = y[:4].tolist()
        flows, past = pumped(t), 2e-11 * (p_a - p_b)
        into_a, into_b = flows.a - past - 1e-12 * p_a, past - flows.b - 1e-12 * p_b
        return [
            p_a * flows.a - p_b * flows.b - 200.0 * v,
            200.0 * v * v,
            (p_a - p_b) * past + 1e-12 * (p_a * p_a + p_b * p_b),
            stored_in_oil(p_a) * into_a + stored_in_oil(p_b) * into_b,
        ]

    def rates(t: float, y: np.ndarray) -> list[float]:
        return rates_of(plant, y, pumped(t), 200.0) + powers(t, y)

    tolerances = [1e-12, 1e-13, 1e-5, 1e-5, *[1e-11] * 4]
    y = solved(rates, [0.0, 0.039, 30e5, 38e5, 0.0, 0.0, 0.0, 0.0], 0.3, atol=tolerances).y

    def stored(v: float, x: float, p_a: float, p_b: float) -> float:
        a, b, length = arm.base_distance, arm.pin_distance, arm.closed_length + x
        angle = math.acos((a * a + b * b - length * length) / (2.0 * a * b))
        turning = v * length / (a * b * math.sin(angle))
        height = math.sin(angle - arm.level_angle)
        moving = 0.5 * arm.moving_mass * v * v + 0.5 * (0.25 + 3.0 * 0.36) * turning**2
        lifted = 9.80665 * (2.0 * 0.3 + 3.0 * 0.6) * height
        volume_a = plant.dead_volume_a + 8e-4 * x
        volume_b = plant.dead_volume_b + 5e-4 * (0.078 - x)
        return moving + lifted + volume_a * stored_in_oil(p_a) + volume_b * stored_in_oil(p_b)

    assert y[2:4].min() > 0.0
    brought, rubbed, leaked, carried = y[4:, -1]
    gained = stored(*y[:4, -1]) - stored(*y[:4, 0])
    exchanged = abs(brought) + rubbed + leaked
    assert exchanged > 1.0
    assert min(rubbed, leaked) > 1e-2
    assert brought + carried - rubbed - leaked == pytest.approx(gained, abs=1e-9 * exchanged)


def test_an_arm_swings_without_loss() -> None:
    """Kinetic energy and height under a constant force, by scipy."""
    arm = example(OneLinkArm)
    force = arm.resistance(0.039, 0.0)

    def rates(_: float, y: np.ndarray) -> list[float]:
        v, x = y.tolist()
        return [(force - arm.resistance(x, v)) / arm.inertia(x), v]

    y = solved(rates, [0.1, 0.03], 0.5, atol=1e-14).y

    def energy(v: float, x: float) -> float:
        a, b, length = arm.base_distance, arm.pin_distance, arm.closed_length + x
        angle = math.acos((a * a + b * b - length * length) / (2.0 * a * b))
        height = 9.80665 * (2.0 * 0.3 + 3.0 * 0.6) * math.sin(angle - arm.level_angle)
        return 0.5 * arm.inertia(x) * v * v + height - force * x

    along = np.array([energy(*one) for one in y.T])
    assert np.ptp(y[1]) > 1e-2
    assert along == pytest.approx(along[0], abs=1e-10 * 0.5 * arm.inertia(0.03) * 0.01)


def jacobian(plant: Cylinder, at: list[float]) -> np.ndarray:
    nudges = [1e-4, 1e-7, 1e3, 1e3]
    columns = []
    for i, nudge in enumerate(nudges):
        high, low = np.array(at), np.array(at)
        high[i] += nudge
        low[i] -= nudge
        difference = np.array(rates_of(plant, high, CLOSED)) - np.array(rates_of(plant, low, CLOSED))
        columns.append(difference / (2.0 * nudge))
    return np.column_stack(columns)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.8])
@pytest.mark.parametrize(("area_a", "area_b"), [(4.91e-4, 4.91e-4), (8e-4, 5e-4)])
def test_natural_frequency(area_a: float, area_b: float, share: float) -> None:
    """Merritt: omega^2 = beta/m (A_A^2/V_A + A_B^2/V_B), with friction and leaks left out."""
    plant = example(Cylinder, area_a=area_a, area_b=area_b, internal_leakage=0.0, friction=Viscous(0.0))
    x = share * plant.stroke
    pressures = [area_b / area_a * 20e5, 20e5]  # no net force
    eigenvalues = np.linalg.eigvals(jacobian(plant, [0.0, x, *pressures]))
    volume_a = plant.dead_volume_a + area_a * x
    volume_b = plant.dead_volume_b + area_b * (plant.stroke - x)
    expected = math.sqrt(7e8 / 6.0 * (area_a**2 / volume_a + area_b**2 / volume_b))
    assert np.abs(eigenvalues.imag).max() == pytest.approx(expected, rel=1e-9)
    assert np.abs(eigenvalues.real).max() < 1e-6 * expected


@pytest.mark.parametrize("x", [0.0, 0.02, 0.039])
def test_exchanged_chambers_mirror_the_motion(x: float) -> None:
    plant = example(Cylinder, external_leakage=1e-12, oil=AeratedOil())
    there = rates_of(plant, np.array([0.1, x, 3e6, 1e6]), PortFlows(3e-5, 1e-5, 0.0, 0.0), 50.0)
    back = rates_of(plant, np.array([-0.1, 0.078 - x, 1e6, 3e6]), PortFlows(-1e-5, -3e-5, 0.0, 0.0), -50.0)
    assert back == pytest.approx([-there[0], -there[1], there[3], there[2]], rel=1e-12)


def responses(amplitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocities of the load-pressure form and of the two chambers, to one sine of the opening.

    The supply's pressure is shared, p_A + p_B = p_s at the start.
    """
    edges, line = example(Orifice), Pressures(40e5, 0.0)
    paper, here = example(LoadPressurePlant), example(Cylinder)
    instants = np.linspace(0.0, 0.1, 401)

    def opening(t: float) -> float:
        return amplitude * math.sin(2.0 * math.pi * 10.0 * t)

    def paper_rates(t: float, y: np.ndarray) -> list[float]:
        s = LoadPressureState(*y.tolist())
        return list(paper.deriv(s, paper.flows(s, open_ports(edges, opening(t), line)), 0.0))

    def here_rates(t: float, y: np.ndarray) -> list[float]:
        s = CylinderState(*y.tolist(), ViscousState())
        return list(here.deriv(s, here.flows(s, open_ports(edges, opening(t), line)), 0.0)[:4])

    starts = [0.0, 0.0, 0.039], [0.0, 0.039, 20e5, 20e5]
    one = solved(paper_rates, starts[0], 0.1, atol=[1e-14, 1e-9, 1e-15], t_eval=instants)
    two = solved(here_rates, starts[1], 0.1, atol=[1e-14, 1e-15, 1e-6, 1e-6], t_eval=instants)
    return one.y[0], two.y[0]


def test_the_load_pressure_form_is_the_limit_of_small_strokes() -> None:
    """With p_A + p_B = p_s and V_A = V_B both agree; a stroke off the middle enters by its square.

    Exchanging the chambers mirrors the motion, so that the first order of V_A - V_B is one of p_A + p_B
    alone, and that of the velocity is zero: half the stroke, a quarter of the relative difference.
    """
    off = []
    for amplitude in (5e-5, 2.5e-5, 1.25e-5):
        paper, here = responses(amplitude)
        off.append(np.abs(paper - here).max() / np.abs(paper).max())
    assert off[0] < 1e-5
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.05)
    assert off[1] / off[2] == pytest.approx(4.0, rel=0.02)


def test_a_torn_chamber_stays_above_absolute_zero_and_fills_again() -> None:
    """Both ports are shut and the rod is drawn out so far that chamber A is void, then let go.

    Each chamber keeps its oil, so its pressure is that of the volume law at its volume, and the same as at
    the start when the piston is back.
    """
    oil = AeratedOil(air_content=1e-3)
    plant = example(Cylinder, internal_leakage=0.0, oil=oil, friction=Viscous(2e4), stops=Stops())

    def rates(t: float, y: np.ndarray) -> list[float]:
        drawn = -1e4 * math.sin(math.pi * t / 0.2) if t < 0.2 else 0.0
        return rates_of(plant, y, CLOSED, drawn)

    done = solve_ivp(
        rates,
        (0.0, 1.0),
        [0.0, 0.039, 5e5, 5e5],
        "Radau",
        rtol=1e-9,
        atol=[1e-9, 1e-12, 1e-3, 1e-3],
        max_step=2e-3,
    )
    assert done.success
    x, pressure_a, pressure_b = done.y[1:4]
    absolute = np.minimum(pressure_a, pressure_b) + ATMOSPHERE
    assert 0.0 < absolute.min() < 0.03 * ATMOSPHERE
    assert pressure_a.argmin() == absolute.argmin()
    for pressure, volume in (
        (pressure_a, plant.dead_volume_a + plant.area_a * x),
        (pressure_b, plant.dead_volume_b + plant.area_b * (plant.stroke - x)),
    ):
        mass = np.array([aerated_density(oil, p) for p in pressure]) * volume
        assert mass == pytest.approx(mass[0], rel=1e-6)
    assert x[-1] == pytest.approx(0.039, abs=1e-6)
    assert [pressure_a[-1], pressure_b[-1]] == pytest.approx([5e5, 5e5], rel=1e-3)


@pytest.mark.parametrize("oil", [example(ConstantOil), AeratedOil()])
def test_rest_under_gravity(oil: Block) -> None:
    """Statics: shut in, the arm comes to rest where the oil carries its weight."""
    plant = example(
        Cylinder,
        internal_leakage=0.0,
        oil=oil,
        friction=Viscous(2e4),
        mechanism=example(OneLinkArm),
        stops=NoStops(),
    )

    def rates(_: float, y: np.ndarray) -> list[float]:
        return rates_of(plant, y, CLOSED)

    done = solve_ivp(
        rates, (0.0, 3.0), [0.0, 0.039, 20e5, 20e5], "Radau", rtol=1e-9, atol=[1e-11, 1e-13, 1e-4, 1e-4]
    )
    v, x, p_a, p_b = done.y[:, -1].tolist()
    weight = example(OneLinkArm).resistance(x, 0.0)
    assert abs(v) < 1e-9
    assert weight > 100.0
    assert plant.area_a * p_a - plant.area_b * p_b == pytest.approx(weight, rel=1e-6)


def test_a_mass_alone_feels_only_the_oil() -> None:
    """At the end of a stroke without stops nothing but the chamber's own stiffness changes."""
    plant = example(Cylinder, stops=NoStops(), mechanism=Mass(6.0))
    inside, outside = (rates_of(plant, np.array([0.0, x, 2e6, 1e6]), CLOSED) for x in (0.077, 0.079))
    assert inside[0] == outside[0] == pytest.approx(4.91e-4 * 1e6 / 6.0)
