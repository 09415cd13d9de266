"""The lemmas against closed forms and scipy."""

import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp

from hydroservo.control.controllers.tsmc import TSMC
from hydroservo.control.observers.tsm import TSMObserver
from hydroservo.core.errors import ParameterError
from hydroservo.core.signals import PortFlows
from hydroservo.machine.plants.load_pressure import LoadPressurePlant, LoadPressureState
from hydroservo.machine.supplies.ideal import IdealSupply
from hydroservo.machine.theory import (
    damping_ratio,
    decayed,
    decrease,
    gain_condition,
    natural_frequency,
    proportional_gain_limit,
    settling_bound,
)
from hydroservo.machine.valves.first_order import FirstOrderValve, FirstOrderValveState
from hydroservo.papers.tsmc_eha_2021.lemmas import condition_17, condition_25, lemma_2
from hydroservo.testing.examples import example

LEMMA_1 = [  # mu [1/s], delta, alpha, V(0)
    (2000.0, 100.0, 6 / 7, 1e-3),
    (200.0, 2.0, 7 / 9, 50.0),
    (3.0, 0.5, 0.5, 2.0),
    (0.2, 5.0, 0.1, 7.0),
]

rates = st.floats(1e-2, 1e3)
exponents = st.floats(0.05, 0.95)


# Lemma 1


@pytest.mark.parametrize(("mu", "delta", "alpha", "initial"), LEMMA_1)
def test_settling_bound_is_the_extinction_time_of_the_equality(
    mu: float, delta: float, alpha: float, initial: float
) -> None:
    end = 1e-9 * initial

    def rate(_: float, v: NDArray[np.float64]) -> NDArray[np.float64]:
        return -mu * v - delta * np.maximum(v, 0.0) ** alpha

    def extinct(_: float, v: NDArray[np.float64]) -> float:
        return float(v[0] - end)

    extinct.terminal = True  # type: ignore[attr-defined]
    right = settling_bound(mu, delta, alpha, initial)
    run = solve_ivp(rate, (0.0, 2.0 * right), [initial], "LSODA", events=extinct, rtol=1e-11, atol=1e-6 * end)
    reached = float(run.t_events[0][0])
    rest, _ = quad(  # from the end of the run to 0, over ln V
        lambda y: 1.0 / (mu + delta * math.exp((alpha - 1.0) * y)),
        math.log(end) - 700.0,
        math.log(end),
        limit=400,
    )
    assert right == pytest.approx(reached + rest, rel=1e-7)


def test_settling_bound_counts_from_the_start() -> None:
    assert settling_bound(3.0, 0.5, 0.5, 0.0, start=2.5) == 2.5
    later = settling_bound(3.0, 0.5, 0.5, 2.0, start=2.5)
    assert later == pytest.approx(2.5 + settling_bound(3.0, 0.5, 0.5, 2.0), rel=1e-15)


def test_settling_bound_tends_to_the_one_without_linear_term() -> None:
    assert settling_bound(1e-9, 0.5, 0.5, 2.0) == pytest.approx(math.sqrt(2.0) / (0.5 * 0.5), rel=1e-8)


@pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize("name", ["linear_rate", "power_rate"])
def test_lemma_1_needs_positive_rates(name: str, wrong: float) -> None:
    values = {"linear_rate": 1.0, "power_rate": 1.0, name: wrong}
    mu, delta = values["linear_rate"], values["power_rate"]
    with pytest.raises(ParameterError, match=f"{name} = .* above 0"):
        settling_bound(mu, delta, 0.5, 1.0)
    with pytest.raises(ParameterError, match=f"{name} = .* above 0"):
        decayed(1.0, mu, delta, 0.5, 1.0)


@pytest.mark.parametrize("wrong", [0.0, 1.0, -0.5, 1.5, math.nan])
def test_lemma_1_needs_an_exponent_between_0_and_1(wrong: float) -> None:
    with pytest.raises(ParameterError, match=r"exponent = .* above 0 and below 1"):
        settling_bound(1.0, 1.0, wrong, 1.0)


@pytest.mark.parametrize("wrong", [-1e-9, math.nan, math.inf])
def test_settling_bound_needs_a_function_that_is_not_negative(wrong: float) -> None:
    with pytest.raises(ParameterError, match=r"initial = .* at least 0"):
        settling_bound(1.0, 1.0, 0.5, wrong)


@pytest.mark.parametrize(("mu", "delta", "alpha", "initial"), LEMMA_1)
def test_decayed_solves_its_equation(mu: float, delta: float, alpha: float, initial: float) -> None:
    times = np.linspace(0.0, 0.7, 8) * settling_bound(mu, delta, alpha, initial)
    run = solve_ivp(
        lambda _, v: -mu * v - delta * v**alpha,
        (0.0, times[-1]),
        [initial],
        "DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-20 * initial,
    )
    np.testing.assert_allclose(decayed(initial, mu, delta, alpha, times), run.y[0], rtol=1e-9)


@given(mu=rates, delta=rates, alpha=exponents, initial=st.floats(1e-6, 1e3))
def test_decayed_is_extinct_at_the_bound_and_not_before(
    mu: float, delta: float, alpha: float, initial: float
) -> None:
    bound = settling_bound(mu, delta, alpha, initial)
    before, after = decayed(initial, mu, delta, alpha, [0.99 * bound, (1.0 + 1e-9) * bound])
    assert before > 0.0
    assert after == 0.0


# Lemma 2


def test_gain_condition_is_gain_over_largest_disturbance() -> None:
    disturbance = 100.0 / 6.0 * np.sin(np.linspace(0.0, 2.0 * np.pi, 4001))
    condition = gain_condition(30.0, disturbance)
    assert condition.largest == pytest.approx(16.0 + 2.0 / 3.0, rel=1e-12)
    assert condition.margin == pytest.approx(1.8, rel=1e-12)
    assert condition.holds


def test_gain_condition_is_strict() -> None:
    assert gain_condition(2.0, [1.0, -2.0]) == (2.0, 1.0, False)
    assert gain_condition(2.0, [1.0, -1.999]).holds
    assert gain_condition(0.0, [0.0]) == (0.0, math.inf, False)
    assert gain_condition(1e-3, [0.0]) == (0.0, math.inf, True)


def test_gain_condition_leaves_out_what_is_not_a_number() -> None:
    assert gain_condition(2.0, [math.nan, -1.0, math.nan]) == (1.0, 2.0, True)
    assert gain_condition(2.0, [math.inf, math.nan]) == (math.inf, 0.0, False)
    nothing = gain_condition(2.0, [math.nan])
    assert math.isnan(nothing.largest)
    assert math.isnan(nothing.margin)
    assert not nothing.holds


def test_gain_condition_needs_a_gain_that_is_not_negative() -> None:
    with pytest.raises(ParameterError, match=r"switching_gain = -1.0"):
        gain_condition(-1.0, [1.0])


def test_lemma_2_judges_both_channels_over_all_samples() -> None:
    data = xr.Dataset({"disturbance_max_1": 15.0, "disturbance_max_2": 1e4})
    first, second = lemma_2(data, example(TSMObserver, switching_gain_1=30.0, switching_gain_2=100.0))
    assert first == (15.0, 2.0, True)
    assert second == (1e4, 0.01, False)


# Conditions (17) and (25)

K, EPS, A = 1000.0, 100.0, 5 / 7


def surface_at(t: NDArray[np.float64], k: float, eps: float, a: float, start: float) -> NDArray[np.float64]:
    """The solution of ds/dt = -k s - eps |s|^a sgn(s)."""
    power = (abs(start) ** (1.0 - a) + eps / k) * np.exp(-k * (1.0 - a) * t) - eps / k
    size: NDArray[np.float64] = np.maximum(power, 0.0) ** (1.0 / (1.0 - a))
    return math.copysign(1.0, start) * size


@pytest.mark.parametrize("start", [0.3, -0.3])
@pytest.mark.parametrize("spacing", [1e-6, 1e-4, 2e-3])
def test_residual_of_the_reaching_law_is_zero(start: float, spacing: float) -> None:
    time = np.arange(0.0, 4e-3, spacing)
    found = decrease(time, surface_at(time, K, EPS, A, start), K, EPS, A, 0.0)
    scale = 0.5 * start**2 / spacing
    np.testing.assert_allclose(found.residual, 0.0, atol=1e-12 * scale)
    assert found.judged.all()
    assert found.fraction == 1.0


def test_residual_tends_to_the_continuous_one() -> None:
    def worst(spacing: float) -> float:
        time = np.arange(0.0, 1.0, spacing)
        s = 2.0 + np.cos(3.0 * time)
        v, v_rate = 0.5 * s**2, -3.0 * s * np.sin(3.0 * time)
        continuous = v_rate + 2.0 * 0.7 * v + 2.0**0.8 * 0.4 * v**0.8
        found = decrease(time, s, 0.7, 0.4, 0.6, 0.0)
        return float(np.max(np.abs(found.residual - continuous[:-1])))

    assert worst(1e-4) == pytest.approx(0.1 * worst(1e-3), rel=1e-2)


def test_faster_holds_and_slower_is_reported() -> None:
    time = np.arange(0.0, 4e-3, 1e-5)
    faster = decrease(time, surface_at(time, 1.01 * K, EPS, A, 0.3), K, EPS, A, 0.0)
    slower = decrease(time, surface_at(time, 0.99 * K, EPS, A, 0.3), K, EPS, A, 0.0)
    assert faster.fraction == 1.0
    assert (faster.residual < 0.0).all()
    assert slower.fraction == 0.0
    assert (slower.residual > 0.0).all()


def test_a_single_violation_is_found_where_it_is() -> None:
    time = np.arange(0.0, 4e-3, 1e-5)
    s = surface_at(time, 1.1 * K, EPS, A, 0.3)
    s[200] = s[199]
    found = decrease(time, s, K, EPS, A, 0.0)
    assert np.flatnonzero(~found.holds).tolist() == [199]
    assert found.fraction == pytest.approx(1.0 - 1.0 / 399.0)
    mu, delta = 2.0 * K, 2.0 ** (0.5 * (1 + A)) * EPS
    v = 0.5 * s[199] ** 2
    assert found.residual[199] == pytest.approx(mu * v + delta * v ** (0.5 * (1 + A)), rel=0.02)


def test_half_the_linear_gain_is_the_printed_form_and_weaker() -> None:
    time = np.arange(0.0, 4e-3, 1e-5)
    s = surface_at(time, 0.75 * K, EPS, A, 0.3)
    assert decrease(time, s, K, EPS, A, 0.0).fraction == 0.0
    assert decrease(time, s, 0.5 * K, EPS, A, 0.0).fraction == 1.0
    half = surface_at(time, 0.5 * K, EPS, A, 0.3)
    printed = decrease(time, half, 0.5 * K, EPS, A, 0.0)
    np.testing.assert_allclose(printed.residual, 0.0, atol=1e-12 * 0.5 * 0.3**2 / 1e-5)


def test_dead_zone_is_not_judged_but_leaving_it_is() -> None:
    found = decrease(range(6), [0.01, -0.01, 0.005, 2.0, 0.01, -0.01], 1.0, 1.0, 0.5, 0.01)
    assert found.judged.tolist() == [False, False, True, True, False]
    assert found.holds.tolist() == [False, False, False, True, False]
    assert found.fraction == 0.5
    assert found.residual[0] == 0.0


def test_nothing_outside_the_dead_zone_is_nothing_to_judge() -> None:
    found = decrease([0.0, 1.0], [0.0, 0.0], 1.0, 1.0, 0.5, 0.0)
    assert not found.judged.any()
    assert math.isnan(found.fraction)


def test_a_surface_that_is_lost_is_a_violation() -> None:
    found = decrease(range(4), [1.0, math.nan, math.nan, math.nan], 1.0, 1.0, 0.5, 0.0)
    assert found.judged.tolist() == [True, False, False]
    assert found.fraction == 0.0


@pytest.mark.parametrize(
    ("time", "surface", "dead_zone", "message"),
    [
        ([0.0], [1.0], 0.0, "at least two samples"),
        ([0.0, 1.0, 2.0], [1.0, 0.5], 0.0, "as long as time"),
        ([[0.0, 1.0]], [[1.0, 0.5]], 0.0, "one row"),
        ([0.0, 1.0], [1.0, 0.5], -1.0, "dead_zone"),
    ],
)
def test_decrease_needs_two_samples_and_a_dead_zone(
    time: list[float], surface: list[float], dead_zone: float, message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        decrease(time, surface, 1.0, 1.0, 0.5, dead_zone)


def test_condition_17_takes_gains_and_dead_zones_of_both_channels() -> None:
    observer = example(TSMObserver, linear_gain_2=400.0, switching_gain_2=2e4)
    time = np.arange(0.0, 2e-2, 1e-4)
    s1 = surface_at(time, 1000.0, 100.0, 5 / 7, 0.5)
    s2 = surface_at(time, 390.0, 10.0, 5 / 7, -50.0)
    data = xr.Dataset(
        {
            "controller.observer.s1": ("time", s1),
            "controller.observer.s2": ("time", s2),
            "disturbance_max_1": 10.0,
            "disturbance_max_2": 5e4,
        },
        coords={"time": time},
    )
    first, second = condition_17(data, observer, 1e-5)
    assert first.fraction == 1.0
    assert second.holds.sum() == 1  # the entry into the dead zone alone
    assert first.judged.sum() == np.count_nonzero(np.abs(s1) > 2e-5 * 30.0)
    assert second.judged.sum() == np.count_nonzero(np.abs(s2) > 2e-5 * 5e4)
    half = observer._replace(linear_gain_2=200.0)  # the printed form
    assert condition_17(data, half, 1e-5)[1].fraction == 1.0


def test_condition_25_takes_the_gains_of_xi2() -> None:
    time = np.arange(0.0, 0.1, 1e-3)
    xi2 = surface_at(time, 100.0, 1.0, 5 / 9, 300.0)
    data = xr.Dataset({"controller.xi2": ("time", xi2)}, coords={"time": time})
    found = condition_25(data, example(TSMC), 1e-2)
    assert found.fraction == 1.0
    np.testing.assert_allclose(found.residual[:60], 0.0, atol=1e-12 * 0.5 * 300.0**2 / 1e-3)
    assert condition_25(data, example(TSMC, linear_gain_2=101.0), 1e-2).fraction < 0.05


# The linearised machine


def state_matrix(
    plant: LoadPressurePlant, valve: FirstOrderValve, supply: IdealSupply, kp: float, ki: float
) -> NDArray[np.float64]:
    """The matrix of the PI loop at rest, with velocity, hydraulic force, opening and integral as its state.

    Each column is what the devices' own equations answer to one small state; at rest they are linear in each.
    """
    small = 1e-9

    def rate(x: NDArray[np.float64]) -> list[float]:
        velocity, hydraulic_force, opening, integral = small * x
        s = LoadPressureState(velocity, hydraulic_force, 0.0)
        flow = valve.orifice.flow(opening, supply.drop(), plant.load_pressure(s))
        moving = plant.deriv(s, PortFlows(flow, flow, 0.0, 0.0), 0.0)
        spool = valve.deriv(FirstOrderValveState(opening), -kp * velocity - integral)
        return [moving.velocity, moving.hydraulic_force, spool.opening, ki * velocity]

    return np.array([rate(unit) for unit in np.eye(4)]).T / small


PLANTS = [
    example(LoadPressurePlant),
    example(LoadPressurePlant, leakage=1e-14),
    example(LoadPressurePlant, 60.0, 20.0, leakage=1e-11),
]


@pytest.mark.parametrize("plant", PLANTS)
def test_frequency_and_damping_are_those_of_the_poles(plant: LoadPressurePlant) -> None:
    poles = np.linalg.eigvals(
        state_matrix(plant, example(FirstOrderValve), example(IdealSupply), 0.0, 0.0)[:2, :2]
    )
    omega, zeta = natural_frequency(plant), damping_ratio(plant)
    assert -np.sum(poles).real == pytest.approx(2.0 * zeta * omega, rel=1e-9)
    product = omega**2 - plant.free_force_rate(0.0, 1.0) * plant.damping / plant.mass
    assert np.prod(poles).real == pytest.approx(product, rel=1e-9)


def test_frequency_and_damping_of_the_paper() -> None:
    plant = example(LoadPressurePlant)
    assert natural_frequency(plant) == pytest.approx(1135.0, abs=0.5)
    assert natural_frequency(plant) / (2.0 * math.pi) == pytest.approx(181.0, abs=0.5)
    assert damping_ratio(plant) == pytest.approx(0.356, abs=1e-3)
    merritt = plant.leakage / plant.piston_area * math.sqrt(
        plant.bulk_modulus * plant.mass / plant.total_volume
    ) + plant.damping / (4.0 * plant.piston_area) * math.sqrt(
        plant.total_volume / (plant.bulk_modulus * plant.mass)
    )
    assert damping_ratio(plant) == pytest.approx(merritt, rel=1e-12)


@pytest.mark.parametrize("integral_gain", [0.0, 10.0, 400.0])
@pytest.mark.parametrize("return_pressure", [0.0, 2e5])
@pytest.mark.parametrize("lag", [0.01, 0.001])
def test_gain_limit_is_where_poles_cross_the_axis(
    integral_gain: float, return_pressure: float, lag: float
) -> None:
    plant, supply = example(LoadPressurePlant), example(IdealSupply, return_pressure=return_pressure)
    valve = example(FirstOrderValve, time_constant=lag)
    limit = proportional_gain_limit(plant, valve, supply, integral_gain)

    def growth(kp: float) -> float:
        poles = np.linalg.eigvals(state_matrix(plant, valve, supply, kp, integral_gain))
        return float(np.max(poles[np.abs(poles) > 1.0].real))  # without the free integral of k_i = 0

    assert growth(limit * (1.0 - 1e-5)) < 0.0
    assert growth(limit * (1.0 + 1e-5)) > 0.0


def test_gain_limit_of_the_paper() -> None:
    """Nominal parameters, corrected leakage, no return pressure, k_i = 10 V/m."""
    plant, valve, supply = example(LoadPressurePlant), example(FirstOrderValve), example(IdealSupply)
    assert proportional_gain_limit(plant, valve, supply, 10.0) == pytest.approx(8.4, abs=0.05)


def test_gain_limit_is_nan_where_the_integral_gain_is_too_large() -> None:
    plant, valve, supply = example(LoadPressurePlant), example(FirstOrderValve), example(IdealSupply)
    assert math.isnan(proportional_gain_limit(plant, valve, supply, 1e4))
    for kp in np.linspace(0.0, 20.0, 201):
        assert np.max(np.linalg.eigvals(state_matrix(plant, valve, supply, kp, 1e4)).real) > 0.0
    with pytest.raises(ParameterError, match="integral_gain"):
        proportional_gain_limit(plant, valve, supply, -1.0)
