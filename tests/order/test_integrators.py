"""Observed order of each integrator on smooth cases, and exactness on polynomials."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo import Loop
from hydroservo.block import Block, leaves
from hydroservo.engine.integrators import RK4
from hydroservo.engine.jit import compiled
from hydroservo.loads import Sine
from hydroservo.loop import MachineState
from hydroservo.plants import LoadPressureState
from hydroservo.valves import FirstOrderValve, FirstOrderValveState

INTEGRATORS = [pytest.param(RK4, 4, id="RK4")]


@cache
def compiled_advance(integrator: type) -> Callable[..., Any]:
    return compiled(vars(integrator)["advance"])


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


def observed_order(
    integrator: type, system: Block, x: Block, u: float, end: float, exact: Any, steps: int
) -> float:
    """The slope of log error against log step, from a step and its half."""
    exact = np.array(exact)
    errors = []
    for substeps in (steps, 2 * steps):
        reached = compiled_advance(integrator)(integrator(substeps), system, 0.0, x, u, end)
        numbers = np.array([number for _, number in leaves(reached)])
        errors.append(float(np.abs((numbers - exact) / exact).max()))
    return math.log2(errors[0] / errors[1])


@pytest.mark.parametrize(("integrator", "order"), INTEGRATORS)
@pytest.mark.parametrize("steps", [32, 64, 128])
def test_order_on_a_smooth_system(integrator: type, order: int, steps: int) -> None:
    system, u, end = Smooth(), -0.5, 2.0
    found = observed_order(integrator, system, Pair(0.1, 1.0), u, end, system.exact(end, u), steps)
    assert found == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize(("integrator", "order"), INTEGRATORS)
@pytest.mark.parametrize("steps", [200, 400, 800])
def test_order_on_the_machine_under_a_sine_load(integrator: type, order: int, steps: int) -> None:
    loop = Loop(valve=FirstOrderValve(), load=Sine(100.0, 50.0, 0.3))
    x = MachineState(LoadPressureState(0.01, 20.0, 0.04), FirstOrderValveState(1e-5))
    u, end = 0.05, 0.02

    def rates(t: float, y: np.ndarray) -> list[float]:
        state = MachineState(LoadPressureState(*y[:3].tolist()), FirstOrderValveState(float(y[3])))
        return [rate for _, rate in leaves(loop.deriv(t, state, u))]

    start = [number for _, number in leaves(x)]
    exact = solve_ivp(rates, (0.0, end), start, "DOP853", rtol=1e-13, atol=1e-20).y[:, -1]
    found = observed_order(integrator, loop, x, u, end, exact, steps)
    assert found == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize(("integrator", "order"), INTEGRATORS)
def test_exact_on_polynomials(integrator: type, order: int) -> None:
    """A rate of degree order - 1 in t is integrated to rounding; one of degree order is not."""
    start, end = 0.5, 1.25
    for degree in range(order + 1):
        advance = compiled_advance(integrator)
        x = Pair(start ** (degree + 1), -3.0 * start)
        reached = advance(integrator(3), Monomial(degree), start, x, -3.0, end - start)
        error = abs(reached.first - end ** (degree + 1))
        assert (error < 8e-15) == (degree < order), (degree, error)
        assert reached.second == pytest.approx(-3.0 * end, abs=8e-15)


@pytest.mark.parametrize(("integrator", "order"), INTEGRATORS)
def test_substeps_end_on_the_sample(integrator: type, order: int) -> None:
    """dt is divided, not the substep multiplied: three substeps of 0.1/3 go as far as one of 0.1."""
    one, three = (
        compiled_advance(integrator)(integrator(n), Monomial(2), 0.3, Pair(0.0, 0.0), 1.0, 0.1)
        for n in (1, 3)
    )
    assert three.first == pytest.approx(one.first, rel=1e-14)
    assert three.second == pytest.approx(one.second, rel=1e-14)
