"""Observed order of each integrator on smooth cases, exactness on polynomials, and the order conditions."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo import Loop, ops
from hydroservo.control.loop import MachineState
from hydroservo.core.block import Block, leaves
from hydroservo.engine.compiling import compiled_function
from hydroservo.machine.drives import ValveOnSupplyState
from hydroservo.machine.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.machine.loads import Sine
from hydroservo.machine.plants import LoadPressureState
from hydroservo.machine.supplies import IdealSupplyState
from hydroservo.machine.valves import FirstOrderValve, FirstOrderValveState
from hydroservo.testing.examples import example


@cache
def compiled_method(integrator: type, name: str) -> Callable[..., Any]:
    return compiled_function(vars(integrator)[name])


def rk4_step(system: Block, t: float, x: Block, u: float, h: float) -> Block:
    return compiled_method(RK4, "substep")(RK4(), system, t, x, u, h)


def rosenbrock_step(system: Block, t: float, x: Block, u: float, h: float) -> Block:
    return compiled_method(Rosenbrock, "substep")(Rosenbrock(), system, t, x, u, h)


def tsit5_step(system: Block, t: float, x: Block, u: float, h: float) -> Block:
    return tsit5_step_and_error(system, t, x, u, h)[0]


def tsit5_step_and_error(system: Block, t: float, x: Block, u: float, h: float) -> tuple[Block, ...]:
    found: tuple[Block, ...] = compiled_method(Tsit5, "step")(Tsit5(), system, t, x, u, h, math.inf)
    return found


INTEGRATORS = [
    pytest.param(rk4_step, 4, id="RK4"),
    pytest.param(rosenbrock_step, 3, id="Rosenbrock"),
    pytest.param(tsit5_step, 5, id="Tsit5"),
]
Step = Callable[[Block, float, Block, float, float], Block]


class Pair(NamedTuple):
    first: float
    second: float


class Smooth(NamedTuple):
    """Logistic growth beside a square-law decay that time modulates; both have closed forms."""

    rate: float = 1.5

    def deriv(self, t: float, x: Pair, u: float) -> Pair:
        return Pair(
            self.rate * x.first * (1.0 - x.first),
            u * (1.0 + 2.0 * t) * x.second * x.second,
        )

    def next_jump(self, t: float, u: float) -> float:
        return math.inf

    def exact(self, t: float, u: float) -> Pair:
        """From first = 0.1 and second = 1 at t = 0."""
        grown = 0.1 * math.exp(self.rate * t)
        return Pair(grown / (0.9 + grown), 1.0 / (1.0 - u * (t + t * t)))


class Monomial(NamedTuple):
    """dx/dt = (k+1) t^k, whose solution t^(k+1) is a polynomial."""

    degree: int

    def deriv(self, t: float, x: Pair, u: float) -> Pair:
        rate = self.degree + 1.0
        for _ in range(self.degree):
            rate *= t
        return Pair(rate, u)

    def next_jump(self, t: float, u: float) -> float:
        return math.inf


def equal_steps(step: Step, system: Block, t: float, x: Block, u: float, end: float, count: int) -> Block:
    h = (end - t) / count
    for i in range(count):
        x = step(system, t + i * h, x, u, h)
    return x


def observed_order(
    step: Step, system: Block, x: Block, u: float, end: float, exact: Any, count: int
) -> float:
    """The slope of log error against log step, from a step and its half."""
    errors = []
    for steps in (count, 2 * count):
        reached = equal_steps(step, system, 0.0, x, u, end, steps)
        numbers = np.array([number for _, number in leaves(reached)])
        errors.append(float(np.abs((numbers - np.array(exact)) / np.array(exact)).max()))
    return math.log2(errors[0] / errors[1])


@pytest.mark.parametrize(("step", "order"), INTEGRATORS)
@pytest.mark.parametrize("count", [16, 32])
def test_order_on_a_smooth_system(step: Step, order: int, count: int) -> None:
    system, u, end = Smooth(), -0.5, 1.0
    found = observed_order(step, system, Pair(0.1, 1.0), u, end, system.exact(end, u), count)
    assert found == pytest.approx(order, abs=0.15)


def order_on_the_machine(step: Step, count: int) -> float:
    """Under a sine load, against DOP853."""
    loop = example(Loop, valve=example(FirstOrderValve), load=Sine(100.0, 50.0, 0.3))
    x = MachineState(
        LoadPressureState(0.01, 20.0, 0.04),
        FirstOrderValveState(1e-5),
        IdealSupplyState(),
        ValveOnSupplyState(),
    )
    u, end = 0.05, 0.02

    def rates(t: float, y: np.ndarray) -> list[float]:
        state = MachineState(
            LoadPressureState(*y[:3].tolist()),
            FirstOrderValveState(float(y[3])),
            IdealSupplyState(),
            ValveOnSupplyState(),
        )
        return [rate for _, rate in leaves(loop.deriv(t, state, u))]

    start = [number for _, number in leaves(x)]
    exact = solve_ivp(rates, (0.0, end), start, "DOP853", rtol=1e-13, atol=1e-20).y[:, -1]
    return observed_order(step, loop, x, u, end, exact, count)


@pytest.mark.parametrize("count", [200, 400])
def test_order_of_rk4_on_the_machine(count: int) -> None:
    assert order_on_the_machine(rk4_step, count) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize("count", [200, 400])
def test_order_of_rosenbrock_on_the_machine(count: int) -> None:
    assert order_on_the_machine(rosenbrock_step, count) == pytest.approx(3.0, abs=0.1)


def test_order_of_tsit5_on_the_machine() -> None:
    """It comes down to 5; where the steps are so short that no term of order 6 is left, only rounding is."""
    coarse, fine = (order_on_the_machine(tsit5_step, count) for count in (100, 200))
    assert coarse > fine > 4.85


@pytest.mark.parametrize(("step", "order"), INTEGRATORS)
def test_exact_on_polynomials(step: Step, order: int) -> None:
    """A rate of degree order - 1 in t is integrated to rounding; one of degree order is not."""
    start, end = 0.5, 1.25
    for degree in range(order + 1):
        x = Pair(start ** (degree + 1), -3.0 * start)
        reached = equal_steps(step, Monomial(degree), start, x, -3.0, end, 3)
        error = abs(reached.first - end ** (degree + 1))
        assert (error < 8e-15) == (degree < order), (degree, error)
        assert reached.second == pytest.approx(-3.0 * end, abs=8e-15)


def test_substeps_end_on_the_sample() -> None:
    """dt is divided, not the substep multiplied: three substeps of 0.1/3 go as far as one of 0.1."""
    one, three = (
        compiled_method(RK4, "advance")(RK4(), Monomial(2), 0.3, Pair(0.0, 0.0), 1.0, 0.1, n) for n in (1, 3)
    )
    assert three.first == pytest.approx(one.first, rel=1e-14)
    assert three.second == pytest.approx(one.second, rel=1e-14)


class Stiff(NamedTuple):
    """x follows cos t with a lag of 1/rate."""

    rate: float

    def deriv(self, t: float, x: Pair, u: float) -> Pair:
        return Pair(-self.rate * (x.first - ops.cos(t)), -self.rate * x.second)

    def next_jump(self, t: float, u: float) -> float:
        return math.inf


@pytest.mark.parametrize("rate", [1e4, 1e7, 1e10])
def test_rosenbrock_follows_a_stiff_motion_with_long_steps(rate: float) -> None:
    """The exact solution, less what has died out: (cos t + sin t/rate)/(1 + 1/rate^2)."""
    reached = equal_steps(rosenbrock_step, Stiff(rate), 0.0, Pair(1.0, 1.0), 0.0, 2.0, 100)
    exact = (math.cos(2.0) + math.sin(2.0) / rate) / (1.0 + rate**-2)
    assert reached.first == pytest.approx(exact, abs=0.02**2 / 10.0)
    assert abs(reached.second) < 1e-12


@pytest.mark.parametrize("h", [0.2, 0.1, 0.05])
def test_the_error_estimate_is_of_order_five(h: float) -> None:
    """It is the difference of results of order 5 and 4, so it falls as the local error of order 4 does."""
    system, x = Smooth(), Pair(0.1, 1.0)
    whole, half = (tsit5_step_and_error(system, 0.3, x, -0.5, one)[1] for one in (h, 0.5 * h))
    for a, b in zip(whole, half, strict=True):
        assert math.log2(a / b) == pytest.approx(5.0, abs=0.4)
    small = [tsit5_step_and_error(system, 0.3, x, -0.5, one)[1].first for one in (0.02, 0.01)]
    assert math.log2(small[0] / small[1]) == pytest.approx(5.0, abs=0.15)


class Seven(NamedTuple):
    a: float
    b: float
    c: float
    d: float
    e: float
    f: float
    g: float


def tableau() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """c, A, the weights, and the weights of the error, read off the method by what it asks and answers.

    With the i-th rate equal to the i-th unit vector, every state shows the weights it was made with.
    """
    asked: list[tuple[float, np.ndarray]] = []

    class Probe(NamedTuple):
        def deriv(self, t: float, x: Seven, u: float) -> Seven:
            asked.append((t, np.array(x)))
            return Seven(*np.eye(7)[len(asked) - 1].tolist())

    y, error, first = Tsit5().step(Probe(), 0.0, Seven(*[0.0] * 7), 0.0, 1.0, math.inf)
    assert first == Seven(1.0, *[0.0] * 6)
    times, rows = zip(*asked, strict=True)
    return np.array(times), np.array(rows), np.array(y), np.array(error)


def order_conditions(a: np.ndarray, c: np.ndarray) -> dict[int, list[tuple[np.ndarray, float]]]:
    """For each order the elementary weights and what a method's weights must make of them.

    Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, table II.2.2.
    """
    ac, acc, aac = a @ c, a @ c**2, a @ (a @ c)
    return {
        1: [(np.ones_like(c), 1.0)],
        2: [(c, 1 / 2)],
        3: [(c**2, 1 / 3), (ac, 1 / 6)],
        4: [(c**3, 1 / 4), (c * ac, 1 / 8), (acc, 1 / 12), (aac, 1 / 24)],
        5: [
            (c**4, 1 / 5),
            (c**2 * ac, 1 / 10),
            (ac**2, 1 / 20),
            (c * acc, 1 / 15),
            (c * aac, 1 / 30),
            (a @ c**3, 1 / 20),
            (a @ (c * ac), 1 / 40),
            (a @ acc, 1 / 60),
            (a @ aac, 1 / 120),
        ],
    }


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_tsit5_meets_the_order_conditions(order: int) -> None:
    c, a, weights, error = tableau()
    assert np.abs(a.sum(axis=1) - c).max() < 2e-15
    for weight, wanted in order_conditions(a, c)[order]:
        assert weights @ weight == pytest.approx(wanted, abs=1e-14)
        if order < 5:
            assert error @ weight == pytest.approx(0.0, abs=1e-14)  # so that the embedded method has order 4
    if order == 5:
        assert max(abs(error @ weight) for weight, _ in order_conditions(a, c)[5]) > 1e-4
