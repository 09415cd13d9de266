"""The Kalman observer: its gain, what it estimates, and where its gains come from."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from hydroservo import Loop, ScenarioError, Simulation, replace, simulate, simulate_batch
from hydroservo.control.controllers import TSMC, ValveInversion
from hydroservo.control.observers import KalmanObserver, PositionKalmanObserver
from hydroservo.core.errors import ParameterError
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.machine.sensors import Difference, NoisySensors, PressureTransducer, RigSensors
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

PERIOD = 1e-3
IDEAL_PRESSURE = PressureTransducer(0.0, 60e5, 0.0, 0.0, 0)
MODEL = example(DesignModel)
FILTER = KalmanObserver(10.0, 1e5, 5e-4, 5.0)
LAW = example(TSMC, 200.0, 300.0, 1.0, 1.0, observer=FILTER)
LOOP = example(
    Loop,
    Simulation(0.2, PERIOD, substeps=10, record_period=PERIOD),
    valve=example(FirstOrderValve),
    sensors=example(NoisySensors),
    controller=example(ValveInversion, LAW),
)
PATH = "controller.controller.observer"


def gains(observer: KalmanObserver) -> np.ndarray:
    return np.array([getattr(observer, f"gain_{i}{j}") for i in range(1, 5) for j in (1, 2)]).reshape(4, 2)


def test_the_gain_is_where_the_riccati_recursion_ends() -> None:
    """The covariance is stepped until it stays, its noise added in a hundred parts of a period."""
    rates = np.zeros((4, 4))
    rates[:2, :2] = [[MODEL.f1(1.0), MODEL.g1()], [MODEL.f2(1.0, 0.0), MODEL.f2(0.0, 1.0)]]
    rates[0, 2] = rates[1, 3] = 1.0
    transition, part = expm(rates * PERIOD), expm(rates * PERIOD / 100)
    added, walk = np.zeros((4, 4)), np.diag([0.0, 0.0, 10.0**2, 1e5**2]) * PERIOD / 100
    for _ in range(100):
        added = part @ (added + 0.5 * walk) @ part.T + 0.5 * walk
    seen, noise = np.eye(2, 4), np.diag([5e-4**2, 5.0**2])
    spread = np.diag([1.0, 1e4, 1e4, 1e10])
    for _ in range(20_000):
        gain = spread @ seen.T @ np.linalg.inv(seen @ spread @ seen.T + noise)
        spread = transition @ (spread - gain @ seen @ spread) @ transition.T + added
    assert gains(FILTER.designed(MODEL, PERIOD)) == pytest.approx(gain, rel=1e-4)


def test_constant_disturbances_are_found_exactly() -> None:
    """A machine that is the model, at rest, under two disturbances that balance each other's motion."""
    observer, d1, d2 = FILTER.designed(MODEL, PERIOD), -8.0, 3e4
    rates = np.array([[MODEL.f1(1.0), MODEL.g1()], [MODEL.f2(1.0, 0.0), MODEL.f2(0.0, 1.0)]])
    x = np.linalg.solve(rates, [-d1, -d2])
    s = observer.init()
    for _ in range(3000):
        s = observer.step(s, MODEL, Measurement(float(x[0]), float(x[1]), 0.0, 0.0, 0.0, 0.0, 0.0), PERIOD)
    assert (s.d1, s.d2) == pytest.approx((d1, d2), rel=1e-3)
    assert (s.velocity, s.hydraulic_force) == pytest.approx(x, rel=1e-3)


def test_it_starts_at_the_first_measurement_and_again_after_a_lost_one() -> None:
    observer = FILTER.designed(MODEL, PERIOD)
    y = Measurement(0.02, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    first = observer.step(observer.init(), MODEL, y, PERIOD)
    assert (first.velocity, first.hydraulic_force, first.d1, first.d2) == (0.02, 50.0, 0.0, 0.0)
    lost = observer.step(first, MODEL, y._replace(velocity=math.nan), PERIOD)
    again = observer.step(lost, MODEL, y, PERIOD)
    assert (again.velocity, again.hydraulic_force, again.d1, again.d2) == (0.02, 50.0, 0.0, 0.0)


def test_it_is_less_noisy_than_what_it_measures() -> None:
    run = simulate(LOOP)
    seen, found = run["sensors.velocity"], run[f"{PATH}.velocity"]
    rms = [float(((one - run["plant.velocity"])[50:] ** 2).mean()) ** 0.5 for one in (seen, found)]
    assert rms[1] < 0.8 * rms[0]


@pytest.mark.slow  # compiles lanes
def test_each_run_of_a_batch_has_its_own_gains() -> None:
    given = np.array([1.0, 100.0, 1.0])
    batch = simulate_batch(LOOP, {f"{PATH}.disturbance_1": given}, strict=True)
    single = [simulate(replace(LOOP, {f"{PATH}.disturbance_1": q}), strict=True) for q in given.tolist()]
    assert batch["rms_error"].values.tolist() == [float(run["rms_error"]) for run in single]
    assert batch["rms_error"].values[0] == batch["rms_error"].values[2] != batch["rms_error"].values[1]


def test_gains_are_not_to_be_given() -> None:
    with pytest.raises(ParameterError, match=r"gain_11'.*is computed before a run"):
        simulate_batch(LOOP, {f"{PATH}.gain_11": np.array([0.1])})
    numbers = example(KalmanObserver)._replace(gain_11=0.1)._asdict()
    changes = {"controller.observer": {"type": "KalmanObserver", **numbers}}
    with pytest.raises(ScenarioError, match=r"gain_11.*is computed before a run; leave it out"):
        load_scenario("paper/sine-tsmc", changes)


def test_parameters_without_a_steady_state_are_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        FILTER._replace(disturbance_1=1e300, velocity_noise=1e-300).designed(MODEL, PERIOD)
    message = str(caught.value)
    assert message.startswith("KalmanObserver.disturbance_1 = 1e+300: with disturbance_2 = 100000, ")
    assert "velocity_noise = 1e-300, hydraulic_force_noise = 5 and a sample period of 0.001 s" in message
    assert message.isprintable()
    with pytest.raises(ParameterError, match=r"^PositionKalmanObserver\.disturbance_1 = .*position_noise = "):
        example(PositionKalmanObserver, disturbance_1=1e300, position_noise=1e-300).designed(MODEL, PERIOD)


def test_a_position_is_as_good_as_its_derivative_without_noise() -> None:
    """Constant disturbances on a machine that is the model, which moves at a constant speed."""
    observer = PositionKalmanObserver(10.0, 1e5, 1e-7, 1.0).designed(MODEL, PERIOD)
    speed, force = 0.03, 40.0
    d1 = -(MODEL.f1(speed) + MODEL.g1() * force)
    d2 = -MODEL.f2(speed, force)
    s = observer.init()
    for k in range(3000):
        y = Measurement(math.nan, force, speed * k * PERIOD, 0.0, 0.0, 0.0, 0.0)
        s = observer.step(s, MODEL, y, PERIOD)
    assert (s.velocity, s.hydraulic_force, s.d1, s.d2) == pytest.approx((speed, force, d1, d2), rel=1e-3)


def test_a_position_filter_beats_differences_of_an_encoder() -> None:
    sensors = example(RigSensors, velocity=Difference(), pressure_a=IDEAL_PRESSURE, pressure_b=IDEAL_PRESSURE)
    law = LAW._replace(observer=PositionKalmanObserver(2.0, 1e4, 3e-7, 2.0))
    run = simulate(LOOP._replace(sensors=sensors, controller=example(ValveInversion, law)))
    differenced, found = run["sensors.velocity.value"], run[f"{PATH}.velocity"]
    rms = [float(((one - run["plant.velocity"])[50:] ** 2).mean()) ** 0.5 for one in (differenced, found)]
    assert rms[1] < 0.7 * rms[0]


def test_a_lost_position_starts_the_filter_again() -> None:
    observer = example(PositionKalmanObserver).designed(MODEL, PERIOD)
    y = Measurement(0.0, 50.0, 0.01, 0.0, 0.0, 0.0, 0.0)
    s = observer.step(observer.init(), MODEL, y, PERIOD)
    assert (s.position, s.hydraulic_force, s.velocity, s.d1) == (0.01, 50.0, 0.0, 0.0)
    again = observer.step(observer.step(s, MODEL, y._replace(position=math.nan), PERIOD), MODEL, y, PERIOD)
    assert (again.position, again.hydraulic_force) == (0.01, 50.0)
