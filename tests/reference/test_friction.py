"""Frictions and contacts against what theory says of them, in motion."""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from hydroservo.engine.compiling import compiled_function
from hydroservo.machine.integrators import RK4
from hydroservo.machine.mechanics import LuGre, LuGreState, Stops, Stribeck, StribeckState
from hydroservo.testing.examples import example

# Table I of Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40(3), 1995; unit mass
LUGRE_1995 = LuGre(1e5, math.sqrt(1e5), 1.0, 1.5, 1e-3, 0.4)
BALL = Stribeck(coulomb=40.0, breakaway=60.0, stribeck_velocity=5e-3, viscous=50.0, stop_time=1e-4)
MASS = 6.0


class SlopeState(NamedTuple):
    """A ball on a slope."""

    velocity: float
    position: float


class Slope(NamedTuple):
    """A mass that a constant force draws against dry friction."""

    pull: float
    friction: Stribeck = BALL

    def deriv(self, t: float, x: SlopeState, u: float) -> SlopeState:
        friction = self.friction.force(StribeckState(), x.velocity, self.pull, MASS)
        return SlopeState((self.pull - friction) / MASS, x.velocity)

    def next_jump(self, t: float, u: float) -> float:
        return math.inf


@pytest.fixture(scope="module")
def advance() -> Any:
    return compiled_function(RK4.advance)


def after(advance: Any, pull: float, start: SlopeState, duration: float) -> SlopeState:
    """By classical Runge-Kutta steps of 20 us."""
    state: SlopeState = advance(RK4(), Slope(pull), 0.0, start, 0.0, duration, round(duration / 2e-5))
    return state


class TestSlope:
    @pytest.mark.parametrize("pull", [0.0, 30.0, -59.9, 59.9])
    def test_below_breakaway_a_ball_stays_where_it_is(self, advance: Any, pull: float) -> None:
        """Not by less than a bit of its position in 100 s."""
        held = after(advance, pull, SlopeState(0.0, 0.039), 100.0)
        assert held == (0.0, 0.039)

    @pytest.mark.parametrize("pull", [30.0, -30.0, 39.0])
    def test_a_ball_that_slides_stops_and_stays(self, advance: Any, pull: float) -> None:
        stopped = after(advance, pull, SlopeState(0.1, 0.039), 2.0)
        assert abs(stopped.velocity) < 1e-15
        assert stopped.position > 0.039
        assert after(advance, pull, stopped, 100.0).position == stopped.position

    def test_above_breakaway_it_slides_at_the_velocity_of_the_curve(self, advance: Any) -> None:
        pull = 61.0

        def excess(v: float) -> float:
            return pull - 50.0 * v - 40.0 - 20.0 / (1.0 + (v / 5e-3) ** 2)

        steady = brentq(excess, 0.1, 1.0, xtol=1e-15)
        assert after(advance, pull, SlopeState(0.0, 0.0), 5.0).velocity == pytest.approx(steady, rel=1e-10)

    def test_stopping_takes_the_way_of_coulomb(self) -> None:
        """Without viscous friction and Stribeck's fall: m v_0^2/(2 F_c), but for the last tau."""
        dry, v0 = Stribeck(40.0, 40.0, 5e-3, 0.0, 1e-5), 0.2

        def rates(_: float, y: np.ndarray) -> list[float]:
            return [-dry.force(StribeckState(), float(y[0]), 0.0, MASS) / MASS, float(y[0])]

        done = solve_ivp(rates, (0.0, 0.1), [v0, 0.0], "Radau", rtol=1e-9, atol=1e-13, max_step=1e-3)
        assert abs(done.y[0, -1]) < 1e-9
        assert done.y[1, -1] == pytest.approx(MASS * v0**2 / (2.0 * 40.0), rel=1e-6)


def test_stick_slip_period() -> None:
    """A mass on a spring whose end moves at a constant velocity, with F_s above F_c and a quick fall.

    It sticks until the spring reaches F_s, then swings about F_c. With D = F_s - F_c, w^2 = k/m and
    g = D/(k V/w): it slips for (2/w) (pi - atan(g)) and sticks for 2 D/(k V), for a Stribeck velocity
    and a stop time of zero (the classical saw-tooth).
    """
    stiffness, mass, pulled = 2.0e4, 5.0, 0.02
    dry = Stribeck(40.0, 60.0, 1e-7, 0.0, 1e-6)

    def rates(_: float, y: np.ndarray) -> list[float]:
        stretch, v = y.tolist()
        net = stiffness * stretch
        return [pulled - v, (net - dry.force(StribeckState(), v, net, mass)) / mass]

    def moving(_: float, y: np.ndarray) -> float:
        return float(y[1]) - 1e-3 * pulled

    moving.direction = 1.0  # type: ignore[attr-defined]
    done = solve_ivp(
        rates, (0.0, 0.9), [0.0, 0.0], "Radau", rtol=1e-8, atol=1e-12, max_step=1e-3, events=moving
    )
    periods = np.diff(done.t_events[0])[1:]
    natural = math.sqrt(stiffness / mass)
    ratio = 20.0 * natural / (stiffness * pulled)
    slip = 2.0 / natural * (math.pi - math.atan(ratio))
    stick = 2.0 * 20.0 / (stiffness * pulled)
    assert len(periods) >= 3
    assert periods == pytest.approx(slip + stick, rel=2e-3)


class TestLuGre:
    def bent(self, friction: LuGre, velocity: Callable[[float], float], duration: float) -> Any:
        """The deflection under a given motion."""

        def rates(t: float, y: np.ndarray) -> list[float]:
            return [friction.deriv(LuGreState(float(y[0])), velocity(t)).deflection]

        done = solve_ivp(rates, (0.0, duration), [0.0], "LSODA", rtol=1e-10, atol=1e-16, dense_output=True)
        assert done.success
        return done.sol

    @pytest.mark.parametrize("friction", [example(LuGre), LUGRE_1995])
    @pytest.mark.parametrize("v", [1e-4, -1e-3, 5e-3, 0.1])
    def test_steady_sliding_gives_the_stribeck_curve(self, friction: LuGre, v: float) -> None:
        slid = 30.0 * friction.breakaway / friction.bristle_stiffness  # many bristles long
        z = self.bent(friction, lambda _: v, slid / abs(v))(slid / abs(v))[0]
        fall = math.exp(-((v / friction.stribeck_velocity) ** 2))
        dry = friction.coulomb + (friction.breakaway - friction.coulomb) * fall
        expected = math.copysign(dry, v) + friction.viscous * v
        assert friction.force(LuGreState(float(z)), v, 0.0, 1.0) == pytest.approx(expected, rel=1e-6)

    @pytest.mark.parametrize("friction", [example(LuGre), LUGRE_1995])
    def test_before_sliding_it_is_a_spring(self, friction: LuGre) -> None:
        """A displacement of a thousandth of F_s/sigma_0, made slowly, meets sigma_0 times it."""
        way = 1e-3 * friction.breakaway / friction.bristle_stiffness
        z = float(self.bent(friction, lambda _: way, 1.0)(1.0)[0])
        assert friction.force(LuGreState(z), 0.0, 0.0, 1.0) == pytest.approx(
            friction.bristle_stiffness * way, rel=2e-3
        )

    def test_presliding_follows_dahl(self) -> None:
        """Slow motion, where g = F_s: sigma_0 z = F_s (1 - e^(-sigma_0 x/F_s)), whatever the velocity."""
        friction = LUGRE_1995
        for v in (1e-7, 1e-6):
            way = 2e-5
            z = float(self.bent(friction, lambda _, v=v: v, way / v)(way / v)[0])
            expected = 1.5 * (1.0 - math.exp(-1e5 * way / 1.5))
            assert 1e5 * z == pytest.approx(expected, rel=1e-5)

    def test_breakaway_falls_with_the_rate_of_the_force(self) -> None:
        """As in the paper of 1995: near F_s for a slow ramp, towards F_c for a fast one."""
        found = []
        for rate in (0.1, 1.0, 10.0, 50.0):

            def rates(t: float, y: np.ndarray, rate: float = rate) -> list[float]:
                z, v = y.tolist()
                friction = LUGRE_1995.force(LuGreState(z), v, rate * t, 1.0)
                return [LUGRE_1995.deriv(LuGreState(z), v).deflection, rate * t - friction]

            def sliding(_: float, y: np.ndarray) -> float:
                return float(y[1]) - 0.1  # a hundred Stribeck velocities

            sliding.terminal = True  # type: ignore[attr-defined]
            done = solve_ivp(rates, (0.0, 20.0), [0.0, 0.0], "LSODA", rtol=1e-8, atol=1e-12, events=sliding)
            found.append(np.max(1e5 * done.y[0]))
        assert (np.diff(found) < 0.0).all()
        assert 1.4 < found[0] < 1.5
        assert 1.0 < found[-1] < 1.3


def leaving(arriving: float) -> float:
    """The u_o of u_i - ln(1 + u_i) = -u_o - ln(1 - u_o), with u = c v."""
    spent = arriving - math.log1p(arriving)
    return float(brentq(lambda u: -u - math.log1p(-u) - spent, 0.0, 1.0 - 1e-12, xtol=1e-15))


def rebound(stops: Stops, speed: float) -> float:
    """The speed at which a free mass leaves the upper end."""

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [float(y[1]), stops.force(0.08 + float(y[0]), float(y[1]), 0.08) / MASS]

    def out(_: float, y: np.ndarray) -> float:
        return float(y[0])

    out.terminal, out.direction = True, -1.0  # type: ignore[attr-defined]
    span = (0.0, 20.0 * math.sqrt(MASS / stops.stiffness))
    done = solve_ivp(rates, span, [0.0, speed], "DOP853", rtol=1e-12, atol=1e-14, events=out)
    assert done.status == 1
    return float(-done.y_events[0][0][1])


class TestContact:
    @pytest.mark.parametrize("speed", [0.003, 0.03, 0.3])
    @pytest.mark.parametrize("stops", [Stops(), Stops(1e7, 1.0)])
    def test_restitution(self, stops: Stops, speed: float) -> None:
        """Of the relation that its energy balance integrates to; for small c v it is 1 - (2/3) c v."""
        found, product = rebound(stops, speed), stops.dissipation * speed
        assert found == pytest.approx(leaving(product) / stops.dissipation, rel=1e-6)
        if product < 0.02:
            assert found / speed == pytest.approx(1.0 - 2.0 / 3.0 * product, abs=product**2)

    def test_without_dissipation_nothing_is_lost(self) -> None:
        assert rebound(Stops(1e8, 0.0), 0.3) == pytest.approx(0.3, rel=1e-9)

    def test_each_rebound_is_slower(self) -> None:
        speeds = [0.5]
        for _ in range(6):
            speeds.append(rebound(Stops(), speeds[-1]))
        assert (np.diff(speeds) < 0.0).all()

    @pytest.mark.parametrize("swing", [5.0, 50.0, 500.0])
    def test_a_forced_cycle_takes_energy(self, swing: float) -> None:
        """Driven in and out of both ends, at any speed: the work on the piston over a cycle is negative."""

        def power(t: float) -> float:
            x, v = 0.04 + 0.041 * math.sin(swing * t), 0.041 * swing * math.cos(swing * t)
            return Stops().force(x, v, 0.08) * v

        edges = np.linspace(0.0, 2.0 * math.pi / swing, 33)
        work = sum(quad(power, a, b, limit=200)[0] for a, b in pairwise(edges))
        assert work < 0.0
