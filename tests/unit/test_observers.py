"""The disturbance observer and its parts, on a plant that is its own sampled model plus a disturbance."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import brentq

from hydroservo.control.observers import (
    BoundaryLayer,
    Explicit,
    FilteredDerivative,
    Implicit,
    ModelDerivative,
    TSMObserver,
)
from hydroservo.core.roles import Realisation
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.machine.theory import settling_bound
from hydroservo.testing.examples import example

H = 1e-5
MODEL = example(DesignModel)
REALISATIONS = [Explicit(), BoundaryLayer(), Implicit()]
ULP = np.finfo(np.float64).eps


class Watched(NamedTuple):
    """An observer's run, sample by sample: shape (n, 2), one column a channel."""

    surface: NDArray[np.float64]
    estimate: NDArray[np.float64]
    disturbance: NDArray[np.float64]  # mean over the period that ends at the sample; nan at the first
    state: NDArray[np.float64]


Disturbance = Callable[[float, float], tuple[float, float]]  # means over a period from its two ends


def waves(start: float, end: float) -> tuple[float, float]:
    """The mean over a period of d1 = 100/6 sin(40 t) [m/s^2] and d2 = 2e4 cos(100 t) [N/s]."""
    d1 = -100.0 / 6.0 * (math.cos(40.0 * end) - math.cos(40.0 * start)) / 40.0
    d2 = 2e4 * (math.sin(100.0 * end) - math.sin(100.0 * start)) / 100.0
    return d1 / (end - start), d2 / (end - start)


def constant(d1: float, d2: float) -> Disturbance:
    return lambda *_: (d1, d2)


def watch(
    observer: TSMObserver,
    disturbance: Disturbance,
    samples: int,
    *,
    h: float = H,
    offset: tuple[float, float] | None = None,
    lost: int | None = None,
) -> Watched:
    """Run an observer beside the plant x' = x + h (f + g u + d), under a small alternating command.

    Args:
        offset: s1 and s2 to start from, in place of v = x.
        lost: the sample whose measurement is not a number.
    """
    state = observer.init()
    if offset is not None:
        state = state._replace(v1=offset[0], v2=offset[1])
    x1 = x2 = u = d1 = d2 = 0.0
    rows = []
    for k in range(samples):
        y = Measurement(x1, x2, 0.0, u, 0.0, 0.0, 0.0)
        seen = y if k != lost else Measurement(math.nan, math.nan, math.nan, u, 0.0, 0.0, 0.0)
        state = observer.step(state, MODEL, seen, h)
        rows.append(((state.s1, state.s2), (state.d1, state.d2), (d1, d2), (x1, x2)))
        g2 = MODEL.g2(x2, u)  # with the sign of the last command, as the observer has it
        u = 0.02 * math.sin(300.0 * k * h)
        d1, d2 = disturbance(k * h, (k + 1) * h)
        x1, x2 = (
            x1 + h * (MODEL.f1(x1) + MODEL.g1() * x2 + d1),
            x2 + h * (MODEL.f2(x1, x2) + g2 * u + d2),
        )
    surface, estimate, true, states = (np.array(column) for column in zip(*rows, strict=True))
    true[0] = math.nan
    return Watched(surface, estimate, true, states)


def rounding(run: Watched) -> NDArray[np.float64]:
    """What rounding of v and x, a few units in the last place each, makes of an estimate."""
    size: NDArray[np.float64] = 8.0 * ULP * np.abs(run.state).max(axis=0) / H
    return size


LARGEST_RATE = np.array(
    [30.0 + 100.0 / 6.0, 3e4 + 2e4]
)  # D + |d|: what a surface can move at, with D_2 = 3e4


def assert_means_agree(run: Watched, window: int) -> None:
    """The mean estimate of the last samples is the mean disturbance, but for what s moved over them.

    Their difference telescopes to the change of s over window h, and a disturbance is seen one sample late.
    """
    mean, true = (values[-window:].mean(axis=0) for values in (run.estimate, run.disturbance))
    assert (np.abs(mean - true) <= 3.0 * LARGEST_RATE / window).all()


# All realisations


@pytest.mark.parametrize("realisation", REALISATIONS)
def test_starts_on_the_surface(realisation: Realisation) -> None:
    observer = example(TSMObserver, realisation=realisation)
    y = Measurement(0.02, 150.0, 0.0, 0.01, 0.0, 0.0, 0.0)
    s = observer.step(observer.init(), MODEL, y, H)
    assert (s.s1, s.s2, s.d1, s.d2) == (0.0, 0.0, 0.0, 0.0)
    assert s.v1 == 0.02 + H * (MODEL.f1(0.02) + MODEL.g1() * 150.0)
    assert s.v2 == 150.0 + H * MODEL.f2(0.02, 150.0)
    assert s.g2 == MODEL.g2(150.0, 0.01)


@pytest.mark.parametrize("realisation", REALISATIONS)
def test_without_disturbance_it_stays_within_one_switch(realisation: Realisation) -> None:
    run = watch(example(TSMObserver, realisation=realisation), constant(0.0, 0.0), 500)
    assert (np.abs(run.surface) <= 1.01 * H * np.array([30.0, 100.0])).all()


@pytest.mark.parametrize("realisation", REALISATIONS)
def test_starts_anew_after_a_measurement_that_is_not_a_number(realisation: Realisation) -> None:
    lost, window = 700, 300
    run = watch(example(TSMObserver, switching_gain_2=3e4, realisation=realisation), waves, 1400, lost=lost)
    assert np.isnan(run.estimate[lost]).all()
    assert (run.surface[lost + 1] == 0.0).all()
    assert (run.estimate[lost + 1] == 0.0).all()
    assert np.isfinite(np.delete(run.estimate, lost, axis=0)).all()
    assert_means_agree(run, window)


# Implicit

SLIDING = example(TSMObserver, switching_gain_2=3e4, realisation=Implicit())


def test_implicit_reaches_the_surface_in_finite_time() -> None:
    offset = (0.05, -200.0)
    run = watch(SLIDING, waves, 3000, offset=offset)
    a = SLIDING.exponent
    for i, (s0, k, eps, spare) in enumerate(
        zip(offset, (1000.0, 1000.0), (100.0, 10.0), (30.0 - 100.0 / 6.0, 1e4), strict=True)
    ):
        size = np.abs(run.surface[:, i])
        reached = int(np.argmax(size == 0.0))
        assert reached > 10
        assert (np.diff(size[: reached + 1]) < 0.0).all()
        assert (size[reached:] == 0.0).all()
        assert reached * H <= settling_bound(
            2.0 * k, 2.0 ** (0.5 * (1 + a)) * eps, 0.5 * (1 + a), 0.5 * s0**2
        )
        assert reached * H <= abs(s0) / spare + H  # by the spare switching gain D - |d| alone


@pytest.mark.parametrize("offset", [None, (0.05, -200.0)])
def test_implicit_estimate_is_the_mean_disturbance_of_the_last_period(
    offset: tuple[float, float] | None,
) -> None:
    run = watch(SLIDING, waves, 3000, offset=offset)
    sliding = slice(1 if offset is None else 2000, None)
    assert (run.surface[sliding] == 0.0).all()
    miss = np.abs(run.estimate - run.disturbance)[sliding]
    assert (miss <= rounding(run)).all()
    assert (rounding(run) < 1e-6).all()


def test_implicit_leaves_the_surface_where_the_gain_is_short() -> None:
    """It then rests where the linear and the power term make up for the difference."""
    run = watch(
        example(TSMObserver, switching_gain_1=10.0, realisation=Implicit()), constant(-15.0, 0.0), 3000
    )
    rest = brentq(lambda s: 1000.0 * s + 100.0 * s ** (5 / 7) - 5.0, 1e-9, 1.0, xtol=1e-16)
    assert run.surface[-1, 0] == pytest.approx(rest, rel=1e-6)


@given(
    s=st.floats(1e-12, 1e4),
    linear=st.floats(0.0, 100.0),
    power=st.floats(0.0, 100.0),
    reach=st.floats(0.0, 1.0),
    exponent=st.floats(0.1, 0.95),
)
def test_implicit_step_solves_its_equation(
    s: float, linear: float, power: float, reach: float, exponent: float
) -> None:
    found = Implicit().first(s, linear, reach, power, exponent, 1.0).surface
    assert Implicit().first(-s, linear, reach, power, exponent, 1.0).surface == -found
    if s <= reach:
        assert found == 0.0
        return
    left = (1.0 + linear) * found + power * found**exponent + reach
    assert left == pytest.approx(s, rel=1e-13)


# Explicit


def test_explicit_estimate_switches_by_the_gain_and_its_mean_converges() -> None:
    observer = example(TSMObserver, switching_gain_2=3e4, realisation=Explicit())
    run = watch(observer, waves, 4000)
    gain = np.array([30.0, 3e4])
    size = np.abs(run.estimate[2:])
    assert (size >= gain).all()
    assert (size <= 1.05 * gain).all()
    switches = np.diff(np.sign(run.estimate[2:]), axis=0) != 0.0
    assert (switches.mean(axis=0) > 0.2).all()
    assert (np.abs(run.surface) <= 1.01 * H * LARGEST_RATE).all()
    for window in (100, 1000, 3000):
        assert_means_agree(run, window)


# Boundary layer


@pytest.mark.parametrize("channel", [0, 1])
def test_boundary_layer_has_a_bandwidth_of_k_plus_gain_over_thickness(channel: int) -> None:
    h, gain, thickness = 1e-6, (30.0, 100.0)[channel], 1e-3
    observer = example(TSMObserver, power_gain_1=0.0, power_gain_2=0.0)
    step = [0.0, 0.0]
    step[channel] = 1e-4 * gain  # small against the gain: tanh is still a line
    bandwidth = 1000.0 + gain / thickness
    samples = int(6.0 / bandwidth / h)
    run = watch(observer, constant(step[0], step[1]), samples, h=h)
    response = run.estimate[:, channel] / step[channel]
    n = np.arange(samples)
    np.testing.assert_allclose(response, 1.0 - (1.0 - h * bandwidth) ** n, atol=1e-6)
    crossed = h * np.argmax(response >= 1.0 - math.exp(-1.0))
    assert crossed == pytest.approx(1.0 / bandwidth, rel=0.1)


def test_boundary_layer_rests_where_its_correction_is_the_disturbance() -> None:
    run = watch(example(TSMObserver), constant(20.0, 0.0), 2000)
    s, d = run.surface[-1, 0], run.estimate[-1, 0]
    assert d == pytest.approx(20.0, rel=1e-9)
    law = 1000.0 * abs(s) + 30.0 * math.tanh(abs(s) / 1e-3) + 100.0 * abs(s) ** (5 / 7)
    assert (law, s < 0.0) == (pytest.approx(20.0, rel=1e-9), True)


# Derivatives


@pytest.mark.parametrize("tau", [0.0, 1e-3, 0.1])
def test_filtered_derivative_of_a_step_and_of_a_ramp(tau: float) -> None:
    block, dt = FilteredDerivative(tau), 1e-4

    def rates(signal: list[float]) -> list[float]:
        state, found = block.init(), []
        for value in signal:
            state = block.step(state, value, 123.0, dt)
            found.append(state.rate)
        return found

    pole = tau / (tau + dt)
    after_step = [0.0] * 10 + [3.0 / (tau + dt) * pole**n for n in range(50)]
    assert rates([2.0] * 10 + [5.0] * 50) == pytest.approx(after_step, rel=1e-9)
    in_ramp = [3.0 * (1.0 - pole**n) for n in range(60)]
    assert rates([7.0 + 3.0 * dt * n for n in range(60)]) == pytest.approx(in_ramp, rel=1e-9, abs=1e-9)


def test_filtered_derivative_passes_a_slow_sine_with_a_lag_of_tau() -> None:
    block, dt, omega = FilteredDerivative(1e-3), 1e-5, 20.0
    time = dt * np.arange(40_000)
    state, found = block.init(), []
    for value in np.sin(omega * time).tolist():
        state = block.step(state, value, 0.0, dt)
        found.append(state.rate)
    settled = time > 0.02
    lagging = omega * np.cos(omega * (time - 1e-3 - 0.5 * dt))
    np.testing.assert_allclose(np.array(found)[settled], lagging[settled], atol=3e-4 * omega)


def test_model_derivative_passes_the_model_rate() -> None:
    block = ModelDerivative()
    assert block.init().rate == 0.0
    assert block.step(block.init(), 5.0, 123.0, 1e-3).rate == 123.0
