"""Adaptive robust control: what it is without adaptation, what it finds, and what keeps it in bounds."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hydroservo import replace, simulate
from hydroservo.control.controllers import AdaptiveRobust, Backstepping, RadialBasis, Saturation
from hydroservo.control.controllers.adaptive_robust import Unknowns
from hydroservo.control.controllers.radial_basis import Weights
from hydroservo.control.observers import ExtendedStateObserver, NoObserver
from hydroservo.control.references import Multisine
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.loads import Constant
from hydroservo.machine.plants import DesignModel
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

MODEL = example(DesignModel)
NAN = float("nan")
KNOWN = Unknowns(1.0, 1.0, 1.0, 1.0, 0.0, 0.0)
STILL = Demand(0.0, 0.0, 0.0)


def seen(velocity: float, hydraulic_force: float, command: float) -> Measurement:
    return Measurement(velocity, hydraulic_force, NAN, command, NAN, NAN, NAN)


class Run(NamedTuple):
    """A run, sample by sample."""

    z1: NDArray[np.float64]
    e2: NDArray[np.float64]  # z2 as a velocity
    estimates: NDArray[np.float64]  # shape (samples, 6)
    unlimited: NDArray[np.float64]
    weights: Block


def motion(
    law: AdaptiveRobust,
    true: Unknowns,
    h: float,
    duration: float,
    demand: Callable[[float], Demand] = lambda _: STILL,
    *,
    start: tuple[float, float] = (0.0, 0.0),
    steps: int = 1,
    noise: float = 0.0,
    lost: int | None = None,
    friction: Callable[[float], float] = lambda _: 0.0,
) -> Run:
    """The law on its own model with other factors, under a held command (classical Runge-Kutta).

    Args:
        steps: of the integrator in a sample period.
        noise: rms of the measured velocity's [m/s], and a 1e4 of the hydraulic force's [N].
        lost: the sample whose measurement is not a number.
        friction: an acceleration that depends on the velocity [m/s^2].
    """

    def rates(x1: float, x2: float, u: float) -> tuple[float, float]:
        pushed = true.stiffness * MODEL.f2(x1, 0.0) + true.leakage * MODEL.f2(0.0, x2) + true.flow
        return (
            true.damping * MODEL.f1(x1) + MODEL.g1() * x2 + true.load + friction(x1),
            pushed + true.input_gain * MODEL.g2(x2, u) * u,
        )

    s, rng, u, step = law.init(), np.random.default_rng(1), 0.0, h / steps
    x1, x2 = start
    rows = []
    for i in range(round(duration / h)):
        y = seen(x1 + noise * rng.standard_normal(), x2 + 1e4 * noise * rng.standard_normal(), u)
        s = law.step(s, y if i != lost else seen(NAN, NAN, u), demand(i * h), h)
        u = s.u if i != lost else u
        rows.append((s.z1, s.z2 * MODEL.g1() / law.velocity_gain, *s.estimates, s.unlimited))
        for _ in range(steps):
            a = rates(x1, x2, u)
            b = rates(x1 + 0.5 * step * a[0], x2 + 0.5 * step * a[1], u)
            c = rates(x1 + 0.5 * step * b[0], x2 + 0.5 * step * b[1], u)
            d = rates(x1 + step * c[0], x2 + step * c[1], u)
            x1 += step / 6.0 * (a[0] + 2.0 * (b[0] + c[0]) + d[0])
            x2 += step / 6.0 * (a[1] + 2.0 * (b[1] + c[1]) + d[1])
    found = np.array(rows)
    return Run(found[:, 0], found[:, 1], found[:, 2:8], found[:, 8], s.weights)


LIVELY = 2.0 * np.pi * np.array([3.0, 17.0, 41.0, 83.0, 131.0])  # rad/s, up to near the oil's resonance
SIZES = 0.03 * np.array([1.0, 0.5, 0.3, 0.2, 0.15])  # m/s


def multisine(t: float) -> Demand:
    angle = LIVELY * t + np.arange(5.0)
    return Demand(
        float((SIZES * np.sin(angle)).sum()),
        float((SIZES * LIVELY * np.cos(angle)).sum()),
        float(-(SIZES * LIVELY**2 * np.sin(angle)).sum()),
    )


# Without adaptation

small = st.floats(-0.05, 0.05)
samples = st.lists(st.tuples(small, st.floats(-500.0, 500.0), small, st.floats(-0.5, 0.5)), min_size=3)


@given(samples, st.sampled_from([NoObserver(), ExtendedStateObserver(400.0, 300.0)]))
def test_without_adaptation_it_is_backstepping(
    rows: list[tuple[float, float, float, float]], observer: Block
) -> None:
    law = example(AdaptiveRobust, 300.0, 700.0, 0.0, 0.0, model=MODEL, observer=observer)
    other = Backstepping(300.0, 700.0, MODEL, observer=observer)
    s, o = law.init(), other.init()
    for velocity, hydraulic_force, value, rate in rows:
        y, r = seen(velocity, hydraulic_force, o.u), Demand(value, rate, 3.0 * rate)
        s, o = law.step(s, y, r, 1e-3), other.step(o, y, r, 1e-3)
        assert s.u == pytest.approx(o.u, rel=1e-9, abs=1e-9)
    assert s.estimates == KNOWN


def test_on_the_model_itself_each_error_decays_by_its_gain() -> None:
    k1, k2, h = 200.0, 500.0, 1e-6
    law = AdaptiveRobust(k1, k2, 0.0, model=MODEL)
    e2 = 0.01  # m/s; alone at first, for z1 = 0
    run = motion(law, KNOWN, h, 0.01, start=(0.0, e2 * k1 / MODEL.g1()))
    t = h * np.arange(len(run.e2))
    assert run.e2 == pytest.approx(e2 * np.exp(-k2 * t), abs=h * k2 * e2)
    # dz1/dt = -k1 z1 + k1 e2
    driven = e2 * k1 / (k1 - k2) * (np.exp(-k2 * t) - np.exp(-k1 * t))
    assert run.z1 == pytest.approx(driven, abs=h * k2 * e2)


@pytest.mark.parametrize("gain", [1e-2, 1.0, 1e9])
def test_the_robust_term_makes_the_second_error_decay_faster(gain: float) -> None:
    k1, k2, h, largest = 200.0, 500.0, 1e-6, 1e5
    law = AdaptiveRobust(k1, k2, 0.0, gain, largest_flow=largest, model=MODEL)
    run = motion(law, KNOWN, h, 2e-4, start=(0.0, 1.0))
    stiff = gain * (largest * MODEL.g1() / k1) ** 2
    factor = 1.0 - h * (k2 + stiff / (1.0 + h * stiff))
    assert run.e2[1:] == pytest.approx(run.e2[:-1] * factor, abs=2e-3 * run.e2[0])


# What is found

OFF = {
    "damping": (2.0, {"damping_spread": 2.0}, 1e8),
    "stiffness": (1.1, {"stiffness_spread": 0.3}, 1e5),
    "leakage": (1.43, {"leakage_spread": 0.8}, 1e5),
    "input_gain": (1.241, {"input_spread": 0.5}, 1e5),
    "load": (-10.0, {"largest_load": 30.0}, 1e5),
    "flow": (2e4, {"largest_flow": 1e5}, 1e5),
}


@pytest.mark.parametrize("name", OFF)
def test_one_thing_that_is_not_as_modelled_is_found(name: str) -> None:
    true, spread, gain = OFF[name]
    law = AdaptiveRobust(300.0, 300.0, gain, model=MODEL, **spread)
    run = motion(law, KNOWN._replace(**{name: true}), 2e-5, 0.2, multisine)
    nominal = KNOWN._asdict()[name]
    found = run.estimates[-1, KNOWN._fields.index(name)]
    assert found - nominal == pytest.approx(true - nominal, rel=0.05)


@pytest.mark.slow  # compiles a loop
def test_of_the_paper_s_machine_off_by_delta_the_factors_are_found() -> None:
    """But for a part in proportion to the sample period: estimates at two of them are extrapolated to 0."""
    names = ("stiffness", "leakage", "input_gain")
    law = AdaptiveRobust(
        300.0,
        300.0,
        1e4,
        damping_spread=0.5,
        stiffness_spread=0.5,
        leakage_spread=0.8,
        input_spread=0.5,
        model=MODEL,
    )
    found = []
    for period in ("10 us", "5 us"):
        loop = load_scenario("paper/sine-pi", {"simulation.duration": "2 s", "simulation.period": period})
        changes = {"controller": law, "load": Constant(0.0), "reference": Multisine(0.01, 6.0, 20)}
        paths = [f"controller.estimates.{name}" for name in names]
        data = simulate(replace(loop, changes), record=paths)
        found.append([float(data[path].values[-1]) for path in paths])
    coarse, fine = np.array(found)
    assert 2.0 * fine - coarse == pytest.approx([1.10, 1.10 * 1.30, 1.10**3 / math.sqrt(1.15)], rel=1e-3)


def test_errors_and_estimates_together_never_grow() -> None:
    """The Lyapunov function of the proof, which takes that dzeta1/dt knows how the estimates change."""
    k, h, spread, load = 300.0, 1e-6, 30.0, 10.0
    gain = 2.5e5 / spread**2
    law = AdaptiveRobust(k, k, gain, largest_load=spread, model=MODEL)
    run = motion(law, KNOWN._replace(load=load), h, 0.02, start=(0.0, 20.0))
    miss = run.estimates[:, 4] - load
    size = run.z1**2 + run.e2**2 + miss**2 / (gain * spread**2)
    assert (np.diff(size) < 0.0).all()
    assert size[-1] < 0.1 * size[0]


# What keeps it in bounds


@pytest.mark.parametrize("gain", [1e2, 1e8])
def test_any_gain_is_stable(gain: float) -> None:
    law = AdaptiveRobust(300.0, 300.0, gain, largest_load=30.0, largest_flow=3e4, model=MODEL)
    run = motion(law, KNOWN._replace(load=10.0, flow=1e4), 1e-3, 3.0, steps=10)
    assert np.abs(run.z1[-500:]).max() < 1e-5
    assert run.estimates[-1, 4] == pytest.approx(10.0, rel=1e-2)


def test_under_noise_the_estimates_stay_in_their_bounds() -> None:
    law = example(AdaptiveRobust, adaptation_gain=1e9, dead_zone=0.0, model=MODEL)
    run = motion(law, KNOWN, 1e-3, 1.0, multisine, steps=10, noise=2e-2)
    spread = np.array([0.4, 0.2, 0.6, 0.5, 30.0, 1e5])
    off = np.abs(run.estimates - np.array(KNOWN)).max(axis=0)
    within = (1.0 + 1e-9) * spread
    assert (off <= within).all()
    assert (off > 0.999 * spread)[[2, 3, 5]].all()  # leakage, input gain and flow get there


def test_within_the_dead_zone_nothing_is_adapted() -> None:
    law = example(AdaptiveRobust, robust_gain=0.0, dead_zone=1e-3, model=MODEL)
    run = motion(law, KNOWN._replace(load=1.0), 1e-4, 0.1)
    size = np.hypot(run.z1, run.e2)
    moved = (np.diff(run.estimates, axis=0) != 0.0).any(axis=1)
    assert moved.any()
    assert (moved == (size[1:] > 1e-3)).all()


def test_while_the_command_is_limited_nothing_is_adapted() -> None:
    law = example(AdaptiveRobust, dead_zone=0.0, saturation=Saturation(0.02), model=MODEL)
    run = motion(law, KNOWN, 1e-4, 0.5, multisine)
    limited = np.abs(run.unlimited) > 0.02
    assert 0.1 < limited.mean() < 0.9
    moved = (np.diff(run.estimates, axis=0) != 0.0).any(axis=1)
    assert (moved == ~limited[:-1]).all()


def test_a_measurement_that_is_not_a_number_leaves_the_estimates_as_they_are() -> None:
    law = example(AdaptiveRobust, dead_zone=0.0, model=MODEL)
    run = motion(law, KNOWN, 1e-4, 0.02, multisine, lost=100)
    assert math.isnan(run.z1[100])
    assert (run.estimates[100] == run.estimates[99]).all()
    assert (run.estimates[-1] != run.estimates[99]).all()
    assert np.isfinite(run.estimates).all()


# A function that is learnt


def test_a_basis_is_a_sum_of_bells_with_its_slope() -> None:
    basis = RadialBasis(0.03, 10.0)
    w = Weights(1.0, -2.0, 0.5, 3.0, 0.0, 1.0, -1.0)
    centres = np.linspace(-0.03, 0.03, 7)
    for v in np.linspace(-0.05, 0.05, 11):
        expected = np.exp(-(((v - centres) / 0.01) ** 2) / 2.0) @ np.array(w)
        assert basis.value(w, basis.at(float(v))) == pytest.approx(expected, rel=1e-12, abs=1e-12)
        step = 1e-7
        rise = basis.value(w, basis.at(float(v + step))) - basis.value(w, basis.at(float(v - step)))
        assert basis.slope(w, basis.at(float(v))) == pytest.approx(rise / (2.0 * step), rel=1e-5, abs=1e-4)


def test_weights_stay_in_their_bounds_and_are_forgotten() -> None:
    basis = RadialBasis(0.03, 10.0, forgetting=2.0)
    w = basis.init()
    for _ in range(100):
        w = basis.adapted(w, basis.at(0.0), 1.0, 1e-3)
    assert max(w) == 10.0
    assert basis.adapted(w, basis.at(0.0), math.nan, 1e-3) == w.scaled(1.0 / 1.002)
    assert basis.adapted(w, basis.at(math.nan), math.nan, 1e-3) == w.scaled(1.0 / 1.002)


def stribeck(velocity: float) -> float:
    """Friction that falls from 8 to 4 m/s^2 with the velocity, and changes its sign over 10 mm/s."""
    return -(4.0 + 4.0 * math.exp(-((velocity / 0.02) ** 2))) * math.tanh(velocity / 0.01)


@pytest.mark.slow
def test_friction_is_learnt_as_a_function_of_the_velocity() -> None:
    """What no constant can hold: it changes its sign at each reversal. Quicker adaptation only follows it."""
    found = []
    for gain in (1.0, 100.0):
        law = AdaptiveRobust(300.0, 300.0, gain, model=MODEL, basis=RadialBasis(0.03, 20.0))
        found.append(motion(law, KNOWN, 1e-3, 20.0, slow, steps=10, friction=stribeck))
    for velocity in (-0.02, -0.01, 0.01, 0.02):
        assert learnt(law, found[0], velocity) == pytest.approx(stribeck(velocity), rel=0.15)
        assert abs(learnt(law, found[1], velocity)) < 0.3 * abs(stribeck(velocity))
    constant = AdaptiveRobust(300.0, 300.0, 1.0, largest_load=20.0, model=MODEL)
    other = motion(constant, KNOWN, 1e-3, 20.0, slow, steps=10, friction=stribeck)
    assert rms(found[0].z1[-4000:]) < 0.15 * rms(other.z1[-4000:])


def learnt(law: AdaptiveRobust, run: Run, velocity: float) -> float:
    found: float = law.basis.value(run.weights, law.basis.at(velocity))
    return found


def slow(t: float) -> Demand:
    """A sine of 30 mm/s and 0.5 Hz."""
    rate = math.pi
    return Demand(
        0.03 * math.sin(rate * t), 0.03 * rate * math.cos(rate * t), -0.03 * rate**2 * math.sin(rate * t)
    )


def rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
