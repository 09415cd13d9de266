"""Integrators between two samples: jumps, tolerance, bounded work, and what is lost stays lost."""

import math
import pickle
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from hydroservo import Loop, integrators, ops, replace
from hydroservo.control.loop import MachineState
from hydroservo.core.block import Block, declared_fields, leaves
from hydroservo.core.roles import Integrator
from hydroservo.core.states import axpy, factored, misses, scaled, solved
from hydroservo.engine.compiling import compiled_function
from hydroservo.machine.drives import ValveOnSupplyState
from hydroservo.machine.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.machine.loads import Square, Step
from hydroservo.machine.plants import LoadPressureState
from hydroservo.machine.supplies import IdealSupplyState
from hydroservo.machine.valves import FirstOrderValve, FirstOrderValveState
from hydroservo.testing.examples import example

LOOP = example(Loop, valve=example(FirstOrderValve), load=Step(0.0, 100.0, 0.0123456))
START = MachineState(
    LoadPressureState(0.01, 20.0, 0.04), FirstOrderValveState(1e-5), IdealSupplyState(), ValveOnSupplyState()
)
U, END = 0.05, 0.02


@cache
def advance(cls: type) -> Any:
    return compiled_function(vars(cls)["advance"])


def flat(x: Block) -> np.ndarray:
    return np.array([number for _, number in leaves(x)])


def state(numbers: np.ndarray) -> MachineState:
    *plant, valve = numbers.tolist()
    return MachineState(
        LoadPressureState(*plant), FirstOrderValveState(valve), IdealSupplyState(), ValveOnSupplyState()
    )


def by_dop853(loop: Block, x: Block, u: float, *ends: float) -> np.ndarray:
    """From one instant to the next, the load in between as it is in the middle."""
    y, t = flat(x), 0.0
    for end in ends:
        held = loop._replace(load=Step(0.0, loop.load.force(0.5 * (t + end)), 0.0))
        done = solve_ivp(
            lambda t, y, held=held: flat(held.deriv(t, state(y), u)),
            (t, end),
            y,
            "DOP853",
            rtol=1e-13,
            atol=1e-18,
        )
        y, t = done.y[:, -1], end
    return y


def error(found: Block, exact: np.ndarray) -> float:
    return float(np.abs(flat(found) / exact - 1.0).max())


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    return by_dop853(LOOP, START, U, LOOP.load.next_jump(0.0), END)


def test_a_jump_inside_a_sample_costs_tsit5_nothing_and_rk4_its_order(exact: np.ndarray) -> None:
    assert error(advance(Tsit5)(Tsit5(1e-11), LOOP, 0.0, START, U, END, 1), exact) < 1e-10
    rk4 = [error(advance(RK4)(RK4(), LOOP, 0.0, START, U, END, n), exact) for n in (400, 800)]
    assert min(rk4) > 1e-7
    none = LOOP._replace(load=Step(0.0, 100.0, 1.0))
    smooth = by_dop853(none, START, U, END)
    assert error(advance(RK4)(RK4(), none, 0.0, START, U, END, 400), smooth) < 1e-8


def test_many_jumps_inside_a_sample() -> None:
    loop = LOOP._replace(load=Square(100.0, 0.0037))
    jumps = [0.0]
    while jumps[-1] < END:
        jumps.append(loop.load.next_jump(jumps[-1]))
    exact = by_dop853(loop, START, U, *jumps[1:-1], END)
    assert error(advance(Tsit5)(Tsit5(1e-11), loop, 0.0, START, U, END, 1), exact) < 1e-9


@pytest.mark.parametrize("substeps", [50, 100])
def test_a_jump_on_a_sample_leaves_rk4_its_order(substeps: int) -> None:
    """The step that ends there does not see it; the 1e-9 that loads count as there is lost, and no more."""
    loop = LOOP._replace(load=Step(0.0, 100.0, 0.01))
    exact = by_dop853(loop, START, U, 0.01, 0.02)
    errors = []
    for n in (substeps, 2 * substeps):
        middle = advance(RK4)(RK4(), loop, 0.0, START, U, 0.01, n)
        errors.append(error(advance(RK4)(RK4(), loop, 0.01, middle, U, 0.01, n), exact))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_the_error_is_in_proportion_to_the_tolerance(exact: np.ndarray) -> None:
    tolerances = np.logspace(-4, -10, 7)
    errors = [error(advance(Tsit5)(Tsit5(one), LOOP, 0.0, START, U, END, 1), exact) for one in tolerances]
    slope, _ = np.polyfit(np.log(tolerances), np.log(errors), 1)
    assert slope == pytest.approx(1.0, abs=0.1)
    assert (np.array(errors) < tolerances).all()


@pytest.mark.parametrize("substeps", [1, 3, 1000, 10**6])
def test_the_first_step_does_not_matter_much(substeps: int, exact: np.ndarray) -> None:
    assert error(advance(Tsit5)(Tsit5(1e-9), LOOP, 0.0, START, U, END, substeps), exact) < 1e-8


def test_agrees_with_dop853_from_sample_to_sample() -> None:
    """With a command that changes at each sample."""
    loop, x, y = LOOP._replace(load=Step(50.0, 50.0)), START, flat(START)
    for k in range(20):
        u = 0.05 * math.cos(k)
        y = by_dop853(loop, state(y), u, 1e-3)
        x = advance(Tsit5)(Tsit5(1e-11), loop, k * 1e-3, x, u, 1e-3, 1)
    assert error(x, y) < 1e-9


SIZES = st.floats(-1.0, 1.0)


@settings(max_examples=40)
@given(
    cls=st.sampled_from([RK4, Rosenbrock, Tsit5]),
    numbers=st.tuples(SIZES, SIZES, SIZES, SIZES, SIZES),
    period=st.floats(1e-4, 1.0),
    scale=st.floats(-4.0, 1.0),
    substeps=st.integers(1, 20),
)
def test_compiled_equals_interpreted(
    cls: type, numbers: tuple[float, ...], period: float, scale: float, substeps: int
) -> None:
    loop = LOOP._replace(load=Square(1e3 * numbers[0], period, 100.0))
    loop = replace(loop, {"plant.bulk_modulus": 7e8 * 10.0**scale})
    x = MachineState(
        LoadPressureState(*numbers[1:4]),
        FirstOrderValveState(1e-3 * numbers[4]),
        IdealSupplyState(),
        ValveOnSupplyState(),
    )
    integrator = cls(1e-6, 50) if cls is Tsit5 else cls()
    arguments = (integrator, loop, 0.37, x, 2.0 * numbers[0], 1e-3, substeps)
    found, expected = advance(cls)(*arguments), vars(cls)["advance"](*arguments)
    assert np.array_equal(flat(found), flat(expected), equal_nan=True)
    assert type(found) is MachineState


class One(NamedTuple):
    value: float


class Counted(NamedTuple):
    """A law that counts how often it is asked."""

    law: Any
    asked: list[float]
    period: float = math.inf

    def deriv(self, t: float, x: One, u: float) -> One:
        self.asked.append(t)
        return One(self.law(t, x.value))

    def next_jump(self, t: float, u: float) -> float:
        return (math.floor(t / self.period) + 1.0) * self.period if self.period < math.inf else math.inf


LAWS = {
    "stiff": (lambda t, x: -1e9 * (x - math.cos(t)), 1.0),
    "chatter": (lambda _t, x: -1e6 * ops.sign(x), 1.0),
    "blow-up": (lambda _t, x: x * x, 1e3),
    "noise": (lambda t, _x: ops.sin(1e8 * t) * 1e3, 0.0),
    "nan": (lambda _t, _x: math.nan, 1.0),
    "inf": (lambda _t, _x: math.inf, 1.0),
    "root": (lambda _t, x: 1e3 * ops.sqrt(0.5 - x), 0.0),
    "lost before": (lambda _t, x: -x, math.nan),
    "constant": (lambda _t, _x: 0.0, 0.0),
}


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("dt", [1.0, 1e-5])
def test_the_work_is_bounded_whatever_the_law(name: str, dt: float) -> None:
    law, start = LAWS[name]
    system = Counted(law, [])
    Tsit5(1e-10, 200).advance(system, 1000.0, One(start), 0.0, dt, 1)
    assert len(system.asked) < 7 * 5 * 200
    assert max(system.asked) <= 1000.0 + dt


def test_jumps_without_end_do_not_hang_it() -> None:
    system = Counted(lambda _t, _x: 1.0, [], period=1e-9)
    reached = Tsit5(1e-10, 50).advance(system, 0.0, One(0.0), 0.0, 1.0, 1)
    assert reached.value == pytest.approx(1.0, rel=1e-12)
    assert len(system.asked) < 7 * 500


@pytest.mark.parametrize("name", ["blow-up", "nan", "inf", "lost before"])
def test_what_is_lost_is_not_a_number(name: str) -> None:
    law, start = LAWS[name]
    assert math.isnan(Tsit5().advance(Counted(law, []), 0.0, One(start), 0.0, 1.0, 1).value)


def test_a_lost_state_costs_little() -> None:
    """So that a lane whose run has diverged does not hold up its neighbours."""
    system = Counted(lambda _t, x: -x, [])
    Tsit5().advance(system, 0.0, One(math.nan), 0.0, 1.0, 1)
    assert len(system.asked) <= 7 * 6


def test_no_rate_is_asked_beyond_a_jump() -> None:
    """Each step is on one side of each jump."""
    asked: list[float] = []
    jump = 0.3

    def law(t: float, x: float) -> float:
        return 1.0 if t < jump else 100.0

    Tsit5(1e-6).advance(Counted(law, asked, jump), 0.0, One(0.0), 0.0, 0.5, 1)
    for first in range(0, len(asked), 7):
        step = asked[first : first + 7]
        assert all(t < jump for t in step) or all(t >= jump for t in step)
    found = Tsit5(1e-6).advance(Counted(law, [], jump), 0.0, One(0.0), 0.0, 0.5, 1)
    assert found.value == pytest.approx(0.3 + 100.0 * 0.2, rel=1e-12)


class Nested(NamedTuple):
    pair: One
    last: float


def test_arithmetic_on_nested_states() -> None:
    x, k = Nested(One(1.0), 2.0), Nested(One(10.0), 20.0)
    assert axpy(x, 0.5, k) == Nested(One(6.0), 12.0)
    assert scaled(0.5, k) == Nested(One(5.0), 10.0)


def test_the_linear_system_of_a_machine_is_solved() -> None:
    """Against numpy, with the Jacobian from central differences."""
    h, x = 1e-3, START
    f = LOOP.deriv(0.0, x, U)
    numbers = flat(x)
    nudges = 1e-6 * (np.abs(numbers) + 1e-6)
    columns = [
        (flat(LOOP.deriv(0.0, state(numbers + d), U)) - flat(LOOP.deriv(0.0, state(numbers - d), U))) / 2.0
        for d in np.diag(nudges)
    ]
    matrix = np.eye(numbers.size) / h - np.stack(columns, axis=1) / nudges
    found = flat(solved(factored(LOOP, 0.0, x, U, f, h), f))
    assert found == pytest.approx(np.linalg.solve(matrix, flat(f)), rel=1e-5)


def test_errors_are_relative_to_size_and_to_what_a_rate_adds() -> None:
    zero, one = Nested(One(0.0), 0.0), Nested(One(1e-3), 1e3)
    off = Nested(One(3e-9), 4e-3)
    assert misses(off, one, zero, zero, 1.0) == pytest.approx(9e-12 + 16e-12)
    assert misses(off, zero, one, zero, 1.0) == pytest.approx(9e-12 + 16e-12)
    assert misses(off, zero, zero, one, 2.0) == pytest.approx((9e-12 + 16e-12) / 4.0)
    assert misses(zero, zero, zero, zero, 1.0) == 0.0
    assert math.isnan(misses(Nested(One(math.nan), 0.0), one, one, one, 1.0))


@pytest.mark.parametrize("cls", [getattr(integrators, name) for name in integrators.__all__])
def test_an_integrator_is_a_block(cls: type) -> None:
    block = cls()
    assert pickle.loads(pickle.dumps(block)) == block
    assert declared_fields(cls).keys() == set(cls._fields)  # type: ignore[attr-defined]
    assert all(field.source and field.meaning for field in declared_fields(cls).values())
    assert "Source:" in (cls.__doc__ or "")
    assert "Fails" in (cls.__doc__ or "")
    assert {name for name in vars(Integrator) if name[0] != "_"} <= set(dir(cls))


def test_how_fast_a_motion_each_one_follows() -> None:
    """A half in h |lambda|; and (h |lambda|)^4/120 is the tolerance."""
    assert RK4().trusted_rate(1e-3, 4) == pytest.approx(2000.0)
    assert Tsit5(1e-6, 100).trusted_rate(1e-3, 1) == pytest.approx(5e4)
    assert Rosenbrock().trusted_rate(1e-3, 4) == math.inf
    assert RK4().substeps_for(1000.0, 1e-3, 1e-6) == 10  # 1/(120e-6)^(1/4) = 9.55
    assert RK4().substeps_for(0.0, 1e-3, 1e-6) == 1
    assert RK4().substeps_for(math.inf, 1e-3, 1e-6) == 10**6
    assert Tsit5().substeps_for(1e9, 1e-3, 1e-6) == 1
