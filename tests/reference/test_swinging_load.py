"""The body that swings at a mechanism's tip: Lagrange's equations, energy, frequencies, limits."""

import math
from collections.abc import Callable
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo import ParameterError, simulate
from hydroservo.control.loop import Loop, Simulation
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Mechanism, role
from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.machine.mechanics import (
    Mass,
    NoStops,
    OneLinkArm,
    Stribeck,
    SwingingLoad,
    SwingingLoadState,
    Viscous,
)
from hydroservo.machine.plants import Cylinder, CylinderState
from hydroservo.testing.examples import example

ARM = example(OneLinkArm, level_angle=1.2)
SLOPE = Mass(30.0, rise=0.6)
LOAD = SwingingLoad(2.0, 0.4, moment_of_inertia=0.05, damping=0.3)
MECHANISMS = [(Mass(30.0), 0.02), (SLOPE, 0.02), (Mass(30.0, rise=-1.0), 0.02), (ARM, 0.01), (ARM, 0.07)]
CLOSED = PortFlows(0.0, 0.0, 0.0, 0.0)

Place = tuple[float, float, float]


def tip_of(mechanism: Block, x: float) -> Place:
    """Where the tip is [m], and how its part is turned [rad], from geometry."""
    if isinstance(mechanism, OneLinkArm):
        a, b, length = mechanism.base_distance, mechanism.pin_distance, mechanism.closed_length + x
        up = math.acos((a * a + b * b - length * length) / (2.0 * a * b)) - mechanism.level_angle
        return mechanism.reach * math.cos(up), mechanism.reach * math.sin(up), up
    return math.cos(math.asin(mechanism.rise)) * x, mechanism.rise * x, 0.0


def slope(function: Callable[[float], float], x: float) -> float:
    """A derivative by differences of the sixth order."""
    h = 2e-4
    pairs = [function(x + k * h) - function(x - k * h) for k in (1, 2, 3)]
    return (45.0 * pairs[0] - 9.0 * pairs[1] + pairs[2]) / (60.0 * h)


def kinetic(mechanism: Block, load: SwingingLoad, x: float, phi: float, v: float, w: float) -> float:
    """Of the load's body, from its centre's velocity, and the mechanism [J]."""
    px, py = (slope(lambda one, i=i: tip_of(mechanism, one)[i], x) * v for i in (0, 1))
    c = load.centre_distance
    across, up = px + c * math.cos(phi) * w, py + c * math.sin(phi) * w
    body = 0.5 * load.mass * (across**2 + up**2) + 0.5 * load.moment_of_inertia * w**2
    return float(body + 0.5 * mechanism.inertia(x) * v**2)


def potential(mechanism: Block, load: SwingingLoad, x: float, phi: float) -> float:
    """Of both [J]."""
    _, height, angle = tip_of(mechanism, x)
    own = (
        9.80665 * (2.0 * 0.3 + 3.0 * 0.6) * math.sin(angle)
        if isinstance(mechanism, OneLinkArm)
        else 9.80665 * mechanism.mass * height
    )
    return own + 9.80665 * load.mass * (height - load.centre_distance * math.cos(phi))


@pytest.mark.parametrize(("mechanism", "x"), MECHANISMS)
@pytest.mark.parametrize("phi", [-0.7, 0.0, 1.4])
@pytest.mark.parametrize(("v", "w"), [(0.0, 0.0), (0.2, -1.5), (-0.3, 2.0)])
def test_it_moves_as_the_lagrangian_says(mechanism: Block, x: float, phi: float, v: float, w: float) -> None:
    """Both accelerations against d/dt dL/dq' - dL/dq = Q solved by differences of L alone."""

    def energy(q: tuple[float, float], rates: tuple[float, float]) -> float:
        return kinetic(mechanism, LOAD, *q, *rates) - potential(mechanism, LOAD, *q)

    def momentum(q: tuple[float, float], rates: tuple[float, float]) -> np.ndarray:
        return matrix(q) @ np.array(rates)

    def matrix(q: tuple[float, float]) -> np.ndarray:
        only_x, only_phi, both = (kinetic(mechanism, LOAD, *q, *one) for one in ((1, 0), (0, 1), (1, 1)))
        return np.array([[2 * only_x, both - only_x - only_phi], [both - only_x - only_phi, 2 * only_phi]])

    force, q, rates = 400.0, (x, phi), (v, w)
    along = np.array(
        [slope(lambda t, i=i: momentum((x + t * v, phi + t * w), rates)[i], 0.0) for i in (0, 1)]
    )
    pulls = np.array(
        [slope(lambda one: energy((one, phi), rates), x), slope(lambda one: energy((x, one), rates), phi)]
    )
    turn = slope(lambda one: tip_of(mechanism, one)[2], x)
    rubbed = LOAD.damping * (w - turn * v)
    wanted = np.linalg.solve(matrix(q), np.array([force + turn * rubbed, -rubbed]) + pulls - along)

    s = SwingingLoadState(phi, w)
    a = (force - LOAD.resistance(s, mechanism, x, v)) / LOAD.inertia(s, mechanism, x)
    found = LOAD.deriv(s, mechanism, x, v, a)
    assert found.angle == w
    assert (a, found.rate) == pytest.approx(tuple(wanted), rel=2e-7, abs=1e-7)


@pytest.mark.parametrize("mechanism", [SLOPE, ARM])
def test_energy_is_accounted_for(mechanism: Block) -> None:
    """What the force and the hinge's friction do is what motion and height gain, to 1e-9."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        v, x, phi, w, *_ = y.tolist()
        s, force = SwingingLoadState(phi, w), 150.0 * math.sin(9.0 * t) - 300.0 * v
        force += LOAD.resistance(SwingingLoadState(0.0, 0.0), mechanism, 0.04, 0.0) - 2e4 * (x - 0.04)
        a = (force - LOAD.resistance(s, mechanism, x, v)) / LOAD.inertia(s, mechanism, x)
        swing = LOAD.deriv(s, mechanism, x, v, a)
        turning = w - mechanism.tip(x).turn * v
        return [a, v, swing.angle, swing.rate, force * v, LOAD.damping * turning * turning]

    start = [0.0, 0.04, 0.5, 0.0, 0.0, 0.0]
    done = solve_ivp(rates, (0.0, 2.0), start, "DOP853", rtol=1e-13, atol=1e-13)
    (v, x, phi, w, brought, rubbed), first = done.y[:, -1], done.y[:, 0]

    def stored(v: float, x: float, phi: float, w: float) -> float:
        return kinetic(mechanism, LOAD, x, phi, v, w) + potential(mechanism, LOAD, x, phi)

    gained = stored(v, x, phi, w) - stored(*first[[0, 1, 2, 3]])
    assert 0.0 < done.y[1].min() < done.y[1].max() < 0.078
    assert min(rubbed, np.ptp(done.y[4])) > 0.1
    assert brought - rubbed == pytest.approx(gained, abs=1e-9 * np.abs(done.y[4]).max())


def swing(mechanism: Block, load: SwingingLoad) -> float:
    """The frequency of small swings on a rod that nothing holds [rad/s], from the equations' slopes."""
    h, x = 1e-5, 0.03
    a, turned = [], []
    for phi in (-h, h):
        s = SwingingLoadState(phi, 0.0)
        a.append(-load.resistance(s, mechanism, x, 0.0) / load.inertia(s, mechanism, x))
        turned.append(load.deriv(s, mechanism, x, 0.0, a[-1]).rate)
    return math.sqrt(-(turned[1] - turned[0]) / (2.0 * h))


def test_small_swings() -> None:
    """On a free level cart omega^2 = g/c (1 + m/M); of a body on a held rod, m g c/I."""
    point = SwingingLoad(5.0, 0.8)
    assert swing(Mass(20.0), point) == pytest.approx(math.sqrt(9.80665 / 0.8 * 1.25), rel=1e-9)
    slopes = [
        LOAD.deriv(SwingingLoadState(phi, 0.0), ARM, 0.03, 0.0, 0.0).rate / phi for phi in (1e-5, -1e-5)
    ]
    assert slopes == pytest.approx([-2.0 * 9.80665 * 0.4 / (0.05 + 2.0 * 0.16)] * 2, rel=1e-9)


@pytest.mark.parametrize("mechanism", [SLOPE, ARM])
def test_a_load_that_vanishes_leaves_the_mechanism(mechanism: Block) -> None:
    load, s = SwingingLoad(1e-14, 0.4), SwingingLoadState(0.4, 3.0)
    assert load.inertia(s, mechanism, 0.05) == pytest.approx(mechanism.inertia(0.05), rel=1e-12)
    assert load.resistance(s, mechanism, 0.05, 0.1) == pytest.approx(
        mechanism.resistance(0.05, 0.1), rel=1e-12
    )


def test_hanging_still_it_weighs_what_a_payload_weighs() -> None:
    rod = SwingingLoad(7.0, 0.4, moment_of_inertia=0.1)
    weighed = rod.resistance(rod.init(), ARM._replace(payload=0.0), 0.05, 0.0)
    assert weighed == pytest.approx(ARM._replace(payload=7.0).resistance(0.05, 0.0), rel=1e-13)


def test_a_stuck_piston_holds_a_swinging_load() -> None:
    """Friction that sticks balances what the swing pulls, for it knows the inertia that the rod meets."""
    plant = example(
        Cylinder,
        mechanism=Mass(30.0),
        carried=SwingingLoad(5.0, 0.4),
        friction=Stribeck(60.0, 80.0, 5e-3),
        stops=NoStops(),
    )
    s = CylinderState(0.0, 0.03, 1e6, 1e6, plant.friction.init(), SwingingLoadState(0.3, 2.0))
    rate = plant.deriv(s, CLOSED, 0.0)
    assert rate.velocity == 0.0
    assert rate.carried.rate == pytest.approx(-9.80665 / 0.4 * math.sin(0.3), rel=1e-13)
    free = plant._replace(friction=Viscous()).deriv(s, CLOSED, 0.0)
    assert abs(free.velocity) > 0.1


def test_in_a_loop_its_angle_is_recorded() -> None:
    """A cart that speeds up leaves its load behind; the same bits compiled and in plain Python."""
    plant = example(Cylinder, mechanism=Mass(9.0, rise=0.1), carried=SwingingLoad(1.0, 0.3))
    loop = example(Loop, Simulation(0.02, 1e-4, record_period=1e-3), plant=plant)
    data, plain = simulate(loop, strict=True), simulate(loop, compiled=False)
    assert data["plant.carried.angle"].attrs["units"] == "rad"
    assert np.abs(data["plant.carried.angle"]).max() > 1e-5
    for name in ("plant.carried.angle", "plant.carried.rate", "plant.velocity"):
        assert data[name].values.tobytes() == plain[name].values.tobytes()


def test_it_starts_at_rest() -> None:
    """With the pressures that hold arm and body, as one that hangs still."""
    plant = example(
        Cylinder, area_a=8e-4, area_b=5e-4, mechanism=ARM, carried=SwingingLoad(1.5, 0.4, start_angle=0.2)
    )
    still = plant._replace(carried=SwingingLoad(1.5, 0.4)).at_rest(Pressures(60e5, 0.0), 30.0)
    rate = still.deriv(still.init(), CLOSED, 30.0)
    assert rate.velocity == pytest.approx(0.0, abs=1e-10)
    assert rate.carried == SwingingLoadState(0.0, pytest.approx(0.0, abs=1e-9))
    turned = plant.at_rest(Pressures(60e5, 0.0), 30.0)
    rate = turned.deriv(turned.init(), CLOSED, 30.0)
    assert rate.velocity == pytest.approx(0.0, abs=1e-10)
    assert rate.carried.rate == pytest.approx(-9.80665 / 0.4 * math.sin(0.2), rel=1e-9)


@role(Mechanism)
class Sledge(NamedTuple):
    """A mechanism as one of one's own may be, which carries nothing."""

    mass: Annotated[float, Field("kg", "mass", above=0)] = 9.0

    def inertia(self, position: float) -> float:
        return self.mass

    def resistance(self, position: float, velocity: float) -> float:
        return 0.0


def test_a_mechanism_of_one_s_own_needs_no_more_than_it_did() -> None:
    """Two methods, without state and tip, and the bits of a mass."""
    simulation = Simulation(0.02, 1e-4, record_period=1e-3)
    runs = [
        simulate(example(Loop, simulation, plant=example(Cylinder, mechanism=one)))
        for one in (Sledge(), Mass(9.0))
    ]
    assert runs[0]["plant.velocity"].values.tobytes() == runs[1]["plant.velocity"].values.tobytes()


def test_a_mechanism_without_a_tip_is_refused() -> None:
    plant = example(Cylinder, mechanism=Sledge(), carried=LOAD)
    with pytest.raises(ParameterError, match=r"mechanism = 'Sledge': has no tip\(position\)"):
        simulate(example(Loop, plant=plant))
