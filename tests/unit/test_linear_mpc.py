"""Predictive control: the linear quadratic law where no limit binds, and the best that limits leave."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.signal import cont2discrete

from hydroservo.control.controllers import LinearMPC, OffsetFreeLQ, RateLimit, Saturation
from hydroservo.control.controllers.linear_mpc import MOVES, Limits, Moves
from hydroservo.control.observers import NoObserver
from hydroservo.control.synthesis.linear_model import model_at_rest
from hydroservo.core.block import Block
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import designed
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.testing.examples import example

MODEL = example(DesignModel)
LAG, PERIOD = 0.01, 1e-3
STILL = Demand(0.0, 0.0, 0.0)


def law(**changes: Any) -> Block:
    plain = LinearMPC(1e-2, LAG, NoObserver(), 1, model=MODEL)
    return designed(plain._replace(**changes), PERIOD, lambda: MODEL)


def lq(**changes: Any) -> Block:
    plain = OffsetFreeLQ(1e-2, LAG, NoObserver(), model=MODEL)
    return designed(plain._replace(**changes), PERIOD, lambda: MODEL)


def machine() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The model at rest behind its valve, sampled by scipy."""
    plant = model_at_rest(MODEL, LAG)
    parts = (plant.rates, plant.driven[:, np.newaxis], np.eye(3), np.zeros((3, 1)))
    transition, driven, *_ = cont2discrete(parts, PERIOD)
    return transition, driven[:, 0]


def motion(one: Block, start: NDArray[np.float64], samples: int = 60) -> tuple[NDArray[np.float64], ...]:
    """States and commands of the machine, its valve closed at first, as a law brings it to rest."""
    transition, driven = machine()
    x, s = start, one.init()
    states, commands = [], []
    for _ in range(samples):
        y = Measurement(float(x[0]), float(x[1]), math.nan, s.u, math.nan, math.nan, math.nan)
        s = one.step(s, y, STILL, PERIOD)
        states.append(x)
        commands.append(s.u)
        x = transition @ x + driven * s.u
    return np.array(states), np.array(commands)


def test_a_load_beyond_all_range_divides_by_nothing() -> None:
    """Its orifice's gain over that of the pressure then there is zero."""
    one = law()
    y = Measurement(0.1, -1e307, 0.1, 1.0, 0.1, 0.0, 0.0)
    assert not math.isnan(one.step(one.init(), y, Demand(0.0, 0.1, 0.1), PERIOD).opening)


def test_where_no_limit_binds_it_is_the_linear_quadratic_law_bit_for_bit() -> None:
    generator = np.random.default_rng(1)
    one, other = law(rate=1e4), lq()
    s, o = one.init(), other.init()
    for _ in range(200):
        velocity, force = generator.normal(0.0, [0.02, 300.0])
        y = Measurement(float(velocity), float(force), math.nan, o.u, math.nan, math.nan, math.nan)
        r = Demand(*generator.normal(0.0, [0.02, 0.1, 1.0]).tolist())
        s, o = one.step(s, y, r, PERIOD), other.step(o, y, r, PERIOD)
        assert s.u == o.u == s.unlimited


def best(one: Block, start: NDArray[np.float64], last: float) -> float:
    """The first correction of least sum of squares within the limits, by Lawson's and Hanson's way.

    Commands are those of the machine followed sample by sample: from a state, and for each correction.
    """
    transition, driven = machine()
    gain = np.array([one.gain_1, one.gain_2, one.gain_3])

    def commands(x: NDArray[np.float64], corrections: NDArray[np.float64]) -> NDArray[np.float64]:
        found = []
        for c in corrections:
            found.append(c - gain @ x)
            for _ in range(one.hold):
                x = transition @ x + driven * (c - gain @ x)
        return np.array(found)

    free = commands(start, np.zeros(MOVES))
    answers = np.array([commands(np.zeros(3), row) for row in np.eye(MOVES)]).T
    rise = one.rate * PERIOD
    rises = np.eye(MOVES) - np.eye(MOVES, k=-1)
    first = np.eye(MOVES)[0] * last
    steps = np.array([rise, *[rise * one.hold] * (MOVES - 1)])
    rows = [answers, -answers]
    ends = [-one.saturation.limit - free, free - one.saturation.limit]
    if np.isfinite(rise):
        rows += [rises @ answers, -rises @ answers]
        ends += [-steps - rises @ free + first, rises @ free - first - steps]
    table, end = np.vstack(rows), np.concatenate(ends)
    miss, _ = nnls(np.vstack([table.T, end]), np.eye(MOVES + 1)[-1], maxiter=10_000)
    left = np.vstack([table.T, end]) @ miss - np.eye(MOVES + 1)[-1]
    return float((answers @ (-left[:-1] / left[-1]))[0])


@pytest.mark.parametrize("rate", [math.inf, 40.0], ids=["size", "rate"])
@pytest.mark.parametrize("hold", [1, 4])
def test_within_limits_it_finds_the_best_corrections(hold: int, rate: float) -> None:
    one = law(hold=hold, rate=rate, steps=10_000, saturation=Saturation(0.05))
    sizes = model_at_rest(MODEL, LAG).sizes
    generator = np.random.default_rng(2)
    bound = 0
    for _ in range(6):
        x = generator.normal(0.0, 0.1, 3) * sizes
        found = one.correction(limits_at(one, x))
        expected = best(one, x, clipped(x[2]))
        assert found == pytest.approx(expected, abs=1e-7)
        bound += abs(expected) > 1e-3
    assert bound > 2


def test_the_command_keeps_its_limits() -> None:
    one = law(rate=20.0, saturation=Saturation(0.03))
    sizes = model_at_rest(MODEL, LAG).sizes
    _, commands = motion(one, np.array([0.3, 0.0, 0.0]) * sizes)
    assert np.abs(commands).max() == pytest.approx(0.03)
    assert np.abs(np.diff(commands, prepend=0.0)).max() <= 20.0 * PERIOD * (1.0 + 1e-12)


def test_where_the_rate_binds_it_costs_less_than_the_linear_law_behind_a_limit() -> None:
    """By the measure that both are designed for."""
    limits = {"saturation": Saturation(0.2)}
    sizes = model_at_rest(MODEL, LAG).sizes
    costs = []
    for one in (law(rate=20.0, steps=300, **limits), RateLimit(lq(**limits), 20.0)):
        states, commands = motion(one, np.array([0.1, 0.0, 0.0]) * sizes, 400)
        costs.append(float(np.sum(states[:, 0] ** 2) + np.sum((1e-2 * commands) ** 2)))
    assert costs[0] < 0.95 * costs[1]


def test_more_steps_come_closer() -> None:
    """Where the first correction ends at no limit itself: later ones are what binds."""
    generator = np.random.default_rng(3)
    sizes = model_at_rest(MODEL, LAG).sizes
    states = [generator.normal(0.0, 0.1, 3) * sizes for _ in range(50)]
    worst = []
    for steps in (3, 30, 300):
        one = law(steps=steps, saturation=Saturation(0.05))
        found = [(limits_at(one, x).low.e1, limits_at(one, x).high.e1, best(one, x, 0.0), x) for x in states]
        inside = [
            (best, x) for low, high, best, x in found if low + 1e-6 < best < high - 1e-6 and best != 0.0
        ]
        assert len(inside) > 3
        worst.append(max(abs(one.correction(limits_at(one, x)) - best) for best, x in inside))
    assert worst[2] < 0.1 * worst[1] < 0.1 * worst[0]


def limits_at(one: Block, x: NDArray[np.float64]) -> Limits:
    """Where the machine is in a state, its valve open as it was commanded."""
    free = Moves(*(np.array([list(row) for row in one.free_response]) @ x).tolist())
    return one.limits(free, 0.0, clipped(x[2]), PERIOD)


def clipped(opening: float) -> float:
    return float(np.clip(opening, -0.05, 0.05))


def test_a_horizon_too_short_for_its_limits_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        law(rate=20.0, saturation=Saturation(10.0))
    assert str(caught.value) == (
        "LinearMPC.rate = 20.0: must be at least 1000 [V/s], so that the command gets from 0 to its limit of "
        "10 V within the horizon of 0.01 s; or take a hold above 1"
    )


def test_weights_out_of_reach_are_refused_in_one_line() -> None:
    with pytest.raises(ParameterError, match=r"^LinearMPC\.effort = 1e\+300: with .* no gain is found"):
        law(effort=1e300)
