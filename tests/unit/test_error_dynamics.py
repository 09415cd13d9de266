"""Error dynamics: the closed forms that they are known by."""

from collections.abc import Callable

import numpy as np
import pytest

from hydroservo.control.error_dynamics import (
    ExplicitReaching,
    HomogeneousErrorDynamics,
    LinearErrorDynamics,
    NaiveSuperTwisting,
    NonsingularTerminalErrorDynamics,
    RISEErrorDynamics,
    SuperTwisting,
    TerminalErrorDynamics,
)
from hydroservo.core.block import Block
from hydroservo.core.signals import VelocityError

Disturbance = Callable[[float], float]


def nothing(t: float) -> float:
    return 0.0


def motion(
    dynamics: Block, start: tuple[float, float], h: float, samples: int, disturbance: Disturbance = nothing
) -> np.ndarray:
    """Error, rate and jerk asked for at each sample of e'' = -q + disturbance, q held over the sample."""
    e, rate = start
    state, rows = dynamics.init(), []
    for k in range(samples):
        state = dynamics.step(state, VelocityError(e, rate, 0.0, 0.0), h)
        q = state.damping + state.restoring
        rows.append((e, rate, q))
        push = disturbance(h * k) - q
        e, rate = e + h * rate + 0.5 * h * h * push, rate + h * push
    return np.array(rows)


def surface(
    dynamics: Block, h: float, samples: int, disturbance: Disturbance, start: float = 0.0
) -> np.ndarray:
    """The surface's values where its gain c is next to nothing, so that it is the error's rate."""
    rows = motion(dynamics, (0.0, start), h, samples, disturbance)
    return rows[:, 1]


def test_linear_has_its_two_poles() -> None:
    h, k1, k2 = 1e-5, 20.0, 50.0
    error = motion(LinearErrorDynamics(k1, k2), (1.0, 0.0), h, 20_000)[:, 0]
    t = h * np.arange(len(error))
    exact = (k2 * np.exp(-k1 * t) - k1 * np.exp(-k2 * t)) / (k2 - k1)
    assert np.abs(error - exact).max() < 1e-3


def test_linear_with_an_integral_leaves_nothing_of_a_constant_disturbance() -> None:
    def load(t: float) -> float:
        return 30.0

    plain, integral = (
        motion(LinearErrorDynamics(20.0, 50.0, k), (0.0, 0.0), 1e-3, 4000, load) for k in (0.0, 5e3)
    )
    assert plain[-1, 0] == pytest.approx(30.0 / (20.0 * 50.0), rel=1e-6)
    assert abs(integral[-1, 0]) < 1e-9


def test_terminal_without_powers_is_linear() -> None:
    terminal = TerminalErrorDynamics(300.0, 500.0, 0.0, 0.0, 0.7, 0.6, ExplicitReaching())
    error = VelocityError(3e-3, -0.2, 0.0, 0.0)
    one, other = terminal.step(terminal.init(), error, 1e-3), LinearErrorDynamics(300.0, 500.0)
    two = other.step(other.init(), error, 1e-3)
    assert one.damping == two.damping
    assert one.restoring == pytest.approx(two.restoring, rel=1e-14)


def test_terminal_is_there_in_finite_time_and_linear_is_not() -> None:
    linear = motion(TerminalErrorDynamics(50.0, 50.0, 0.0, 0.0, 0.7, 0.6), (1.0, 0.0), 1e-4, 4000)
    terminal = motion(TerminalErrorDynamics(50.0, 50.0, 5.0, 50.0, 0.7, 0.6), (1.0, 0.0), 1e-4, 4000)
    assert abs(linear[-1, 0]) > 1e-8
    assert abs(terminal[-1, 0]) < 1e-14


def test_nonsingular_terminal_slides_for_as_long_as_its_closed_form_says() -> None:
    p, beta, e0, h = 9 / 7, 1.0, 1.0, 1e-3
    dynamics = NonsingularTerminalErrorDynamics(beta, 500.0, 0.0, p, 0.5)
    error = motion(dynamics, (e0, -((beta * e0) ** (1 / p))), h, 6000)[:, 0]
    gone = h * int(np.argmax(np.abs(error) < 1e-6))
    assert gone == pytest.approx(p / (p - 1) * beta ** (-1 / p) * e0 ** (1 - 1 / p), rel=0.06)
    assert dynamics.surface_exponent / (p - 1) == pytest.approx(4.5)


def test_homogeneous_motions_are_each_other_s_scaled() -> None:
    a, scale = 0.8, 3.0
    dynamics = HomogeneousErrorDynamics(20.0, 10.0, a)
    one = motion(dynamics, (1.0, 0.0), 1e-4, 5000)
    # e scales by s^(2-a), the rate by s, time by s^(1-a)
    other = motion(dynamics, (scale ** (2 - a), 0.0), 1e-4 * scale ** (1 - a), 5000)
    assert np.abs(other[:, 0] / scale ** (2 - a) - one[:, 0]).max() < 1e-12


def test_homogeneous_ends_in_finite_time() -> None:
    assert abs(motion(HomogeneousErrorDynamics(60.0, 20.0, 0.6), (1.0, 0.0), 1e-4, 30_000)[-1, 0]) < 1e-6


L, H = 40.0, 1e-3


def swell(t: float) -> float:
    """Its rate is within L."""
    return 9.0 + 2.0 * float(np.sin(L / 2.0 * t))


def test_super_twisting_leaves_no_more_than_any_law_can() -> None:
    sigma = surface(SuperTwisting(1e-9, L), H, 4000, swell)[2000:]
    assert np.abs(sigma).max() <= 1.001 * H * H * L
    assert np.abs(sigma).max() > 0.5 * H * H * L


def test_the_usual_implicit_step_forgets_the_disturbance() -> None:
    sigma = surface(NaiveSuperTwisting(1e-9, L), H, 4000, swell)[2000:]
    assert np.abs(sigma).max() == pytest.approx(H * 11.0, rel=1e-2)


@pytest.mark.parametrize("cls", [SuperTwisting, NaiveSuperTwisting])
def test_super_twisting_scales_with_its_disturbance(cls: type) -> None:
    scale = 64.0  # a power of two, and of four for the root
    one = surface(cls(1e-9, L), H, 500, swell, 0.3)
    other = surface(cls(1e-9, scale * L), H, 500, lambda t: scale * swell(t), scale * 0.3)
    assert other == pytest.approx(scale * one, rel=1e-12, abs=1e-15)


def test_super_twisting_reaches_its_surface_in_finite_time() -> None:
    sigma = surface(SuperTwisting(1e-9, L), H, 1000, nothing, 1.0)
    assert np.abs(sigma[800:]).max() < 1e-10  # c times the error that is left


def test_rise_leaves_nothing_of_a_disturbance_that_does_not_change() -> None:
    dynamics = RISEErrorDynamics(20.0, 50.0, 10.0, 100.0)
    rows = motion(dynamics, (0.01, 0.0), 1e-4, 20_000, lambda _: 5.0)
    assert abs(rows[-1, 0]) < 1e-5
    assert rows[-1, 2] == pytest.approx(5.0, rel=0.02)


DYNAMICS: list[Block] = [
    LinearErrorDynamics(20.0, 50.0),
    TerminalErrorDynamics(20.0, 50.0, 1.0, 1.0, 0.7, 0.6),
    NonsingularTerminalErrorDynamics(100.0, 50.0, 5.0, 9 / 7, 0.5),
    HomogeneousErrorDynamics(60.0, 20.0, 0.8),
    SuperTwisting(20.0, 100.0),
    NaiveSuperTwisting(20.0, 100.0),
    RISEErrorDynamics(20.0, 50.0, 10.0, 100.0),
]


@pytest.mark.parametrize("dynamics", DYNAMICS, ids=lambda dynamics: type(dynamics).__name__)
def test_each_brings_an_error_to_0_from_either_side(dynamics: Block) -> None:
    up, down = (motion(dynamics, (sign, 0.0), 1e-3, 3000)[:, 0] for sign in (1.0, -1.0))
    assert abs(up[-1]) < 2e-3
    assert down == pytest.approx(-up, abs=1e-12)


@pytest.mark.parametrize("dynamics", DYNAMICS, ids=lambda dynamics: type(dynamics).__name__)
def test_an_observer_s_surfaces_shift_that_of_the_error_dynamics(dynamics: Block) -> None:
    whole = dynamics.step(dynamics.init(), VelocityError(1e-3, 0.05, 0.0, 0.0), 1e-3)
    shifted = dynamics.step(dynamics.init(), VelocityError(1e-3, 0.05, 0.01, 0.02), 1e-3)
    one, other = (state.damping + state.restoring for state in (whole, shifted))
    assert other > one
