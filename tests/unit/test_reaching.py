"""How a reaching law is realised in discrete time."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.control.error_dynamics import ExplicitReaching, ImplicitReaching, SmoothReaching

K, EPS, A = 300.0, 5.0, 5 / 7
surfaces = st.floats(1e-6, 1.0).flatmap(lambda size: st.sampled_from([size, -size]))
REACHINGS = [ExplicitReaching(), SmoothReaching(), ImplicitReaching()]
Any_ = ExplicitReaching | SmoothReaching | ImplicitReaching


@given(s=surfaces, dt=st.floats(1e-6, 0.1), k=st.floats(0.0, 1e4), eps=st.floats(0.0, 1e3))
def test_the_implicit_rate_is_that_of_the_surface_it_leads_to(
    s: float, dt: float, k: float, eps: float
) -> None:
    ahead = s - dt * ImplicitReaching().first(s, k, eps, A, dt).rate
    assert ahead * s >= 0.0
    rest = abs(ahead) + dt * (k * abs(ahead) + eps * abs(ahead) ** A)
    assert rest == pytest.approx(abs(s), rel=1e-9, abs=dt * eps * (4e-16 * abs(s)) ** A)


@given(s=surfaces, dt=st.floats(1e-6, 0.1))
def test_the_implicit_slope_never_passes_one_over_the_period(s: float, dt: float) -> None:
    rate = ImplicitReaching().first(s, K, EPS, A, dt)
    assert 0.0 < rate.slope <= 1.0 / dt * (1.0 + 1e-12)
    assert ImplicitReaching().first(0.0, K, EPS, A, dt).slope == pytest.approx(1.0 / dt, rel=1e-9)


@pytest.mark.parametrize("reaching", REACHINGS, ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("s", [-0.3, 0.02, 1.5])
def test_the_slope_is_the_derivative_of_the_rate(reaching: Any_, s: float) -> None:
    if isinstance(reaching, ExplicitReaching):
        reaching = ExplicitReaching(least_surface=1e-12)
    nudge, dt = 1e-6 * abs(s), 1e-3
    above, below = (reaching.first(x, K, EPS, A, dt).rate for x in (s + nudge, s - nudge))
    assert reaching.first(s, K, EPS, A, dt).slope == pytest.approx((above - below) / (2.0 * nudge), rel=1e-6)


@pytest.mark.parametrize("reaching", REACHINGS, ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("s", [-0.3, 0.02, 1.5])
def test_every_form_tends_to_the_continuous_rate(reaching: Any_, s: float) -> None:
    if isinstance(reaching, SmoothReaching):
        reaching = SmoothReaching(1e-9, 1e-9)
    exact = (K * abs(s) + EPS * abs(s) ** A) * (1.0 if s > 0.0 else -1.0)
    assert reaching.first(s, K, EPS, A, 1e-9).rate == pytest.approx(exact, rel=1e-6)
    assert reaching.second(s, K, EPS, A, 1e-9) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("reaching", REACHINGS, ids=lambda one: type(one).__name__)
def test_the_rate_is_0_on_the_surface(reaching: Any_) -> None:
    assert reaching.first(0.0, K, EPS, A, 1e-3).rate == 0.0
    assert reaching.second(0.0, K, EPS, A, 1e-3) == 0.0


@pytest.mark.parametrize(("gain", "explicit_stays"), [(500.0, True), (3000.0, False)])
def test_the_implicit_form_is_stable_at_any_gain(gain: float, explicit_stays: bool) -> None:
    """ds/dt = -rate, sampled at 1 kHz: the explicit form needs k dt < 2."""
    explicit = implicit = 1.0
    for _ in range(50):
        explicit -= 1e-3 * ExplicitReaching().second(explicit, gain, 0.0, A, 1e-3)
        implicit -= 1e-3 * ImplicitReaching().second(implicit, gain, 0.0, A, 1e-3)
    assert (abs(explicit) < 1.0) == explicit_stays
    assert 0.0 <= implicit < 1e-8
