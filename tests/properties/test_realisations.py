"""The three realisations of sgn, over wide ranges of gains and surfaces."""

import math
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from hydroservo.control.observers import BoundaryLayer, Explicit, Implicit


def powers_of_ten(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda power: 10.0**power)


ROUNDING = 1e-13  # relative, of the implicit surface


class Law(NamedTuple):
    """The arguments of a realisation."""

    s: float
    k: float
    D: float
    eps: float
    a: float
    dt: float


surfaces = st.builds(lambda size, side: side * size, powers_of_ten(-12, 4), st.sampled_from([-1.0, 1.0]))
gains = st.one_of(st.just(0.0), powers_of_ten(-3, 6))
exponents = st.floats(0.1, 0.95)  # below, six steps of Newton's method no longer reach rounding
laws = st.builds(Law, surfaces, gains, gains, gains, exponents, powers_of_ten(-6, -2))


@settings(max_examples=2000)
@given(law=laws)
def test_the_implicit_step_is_the_root(law: Law) -> None:
    s, k, D, eps, a, dt = law
    surface = Implicit().first(*law).surface
    excess = abs(s) - dt * D
    if excess <= 0.0:
        assert surface == 0.0
        return

    def residual(sigma: float) -> float:
        return (1.0 + dt * k) * sigma + dt * eps * sigma**a - excess

    root = brentq(residual, 0.0, excess, xtol=1e-300, rtol=1e-15, maxiter=10_000)
    assert surface == pytest.approx(math.copysign(root, s), rel=ROUNDING, abs=0.0)


@settings(max_examples=500)
@given(law=laws)
def test_the_implicit_surface_shrinks_and_keeps_its_side(law: Law) -> None:
    surface = Implicit().first(*law).surface
    assert abs(surface) <= abs(law.s) * (1.0 + ROUNDING)
    assert surface * law.s >= 0.0
    assert (surface == 0.0) == (abs(law.s) <= law.dt * law.D)


@settings(max_examples=500)
@given(law=laws)
def test_the_implicit_estimate_is_bounded(law: Law) -> None:
    """By the reaching law's own size, and so by D while the surface is held."""
    correction = Implicit().second(*law)
    size = abs(correction.surface)
    rounding = ROUNDING * abs(law.s) / law.dt
    assert abs(correction.estimate) <= law.D + law.k * size + law.eps * size**law.a + rounding
    assert math.copysign(1.0, law.s) * correction.estimate <= rounding
    if size == 0.0:
        assert abs(correction.estimate) <= law.D * (1.0 + 1e-15)


@given(law=laws, realisation=st.sampled_from([Explicit(), BoundaryLayer(), BoundaryLayer(1.0, 1.0)]))
def test_the_direct_estimates_are_odd_and_bounded(law: Law, realisation: Explicit | BoundaryLayer) -> None:
    correction = realisation.first(*law)
    size = abs(law.s)
    assert correction.surface == law.s
    assert abs(correction.estimate) <= (law.k * size + law.D + law.eps * size**law.a) * (1.0 + 1e-15)
    assert correction.estimate * law.s <= 0.0
    assert realisation.first(*law._replace(s=-law.s)).estimate == -correction.estimate


@given(law=laws, side=st.sampled_from([-1.0, 1.0]))
def test_a_thin_boundary_layer_is_the_explicit_law_outside_it(law: Law, side: float) -> None:
    thin = BoundaryLayer(1e-3 * abs(law.s), 1e-3 * abs(law.s))
    assert thin.first(*law) == Explicit().first(*law)
    assert thin.second(*law) == Explicit().second(*law)


@given(law=laws)
def test_at_the_surface_nothing_is_estimated(law: Law) -> None:
    for realisation in (Explicit(), BoundaryLayer(), Implicit()):
        assert realisation.first(*law._replace(s=0.0)) == (0.0, 0.0)
