"""Friction and contact take energy and give none, for any parameters and motions."""

from hypothesis import given
from hypothesis import strategies as st

from hydroservo.machine.mechanics import LuGre, LuGreState, Stribeck, StribeckState, Viscous, ViscousState
from hydroservo.testing.examples import example

velocities = st.floats(-1.0, 1.0)
forces = st.floats(-1e5, 1e5)
masses = st.floats(0.1, 1e4)
drops = st.floats(0.0, 100.0)


def stribecks() -> st.SearchStrategy[Stribeck]:
    return st.builds(
        lambda coulomb, more, velocity, viscous, stop: Stribeck(
            coulomb, coulomb + more, velocity, viscous, stop
        ),
        drops,
        drops,
        st.floats(1e-4, 0.1),
        drops,
        st.floats(1e-5, 1e-2),
    )


def lugres(share: float) -> st.SearchStrategy[LuGre]:
    """With sigma_1 at a share of its passive limit sigma_2 F_c/(F_s - F_c)."""
    return st.builds(
        lambda stiffness, viscous, coulomb, more, velocity: LuGre(
            stiffness, share * viscous * coulomb / more, coulomb, coulomb + more, velocity, viscous
        ),
        st.floats(1e4, 1e8),
        st.floats(1.0, 1e3),
        st.floats(1.0, 100.0),
        st.floats(1.0, 100.0),
        st.floats(1e-3, 0.1),
    )


@given(coefficient=drops, v=velocities, net=forces)
def test_viscous(coefficient: float, v: float, net: float) -> None:
    assert Viscous(coefficient).force(ViscousState(), v, net, 1.0) * v >= 0.0


@given(friction=stribecks(), v=velocities, net=forces, mass=masses)
def test_dry_friction_opposes_the_motion_that_it_leads_to(
    friction: Stribeck, v: float, net: float, mass: float
) -> None:
    """At the velocity one stop time ahead, of the step that its law is the resolvent of."""
    force = friction.force(StribeckState(), v, net, mass)
    dry = force - friction.viscous * v
    ahead = v + friction.stop_time * (net - force) / mass
    rounding = 1e-13 * (abs(v) + friction.stop_time * (abs(net) + abs(force)) / mass)
    assert abs(dry) <= friction.limit(v) * (1.0 + 1e-12) + 1e-12 * abs(force)
    assert dry * ahead >= -abs(dry) * rounding


@given(friction=stribecks(), v=velocities, net=forces, mass=masses)
def test_what_dry_friction_gives_back_is_bounded(
    friction: Stribeck, v: float, net: float, mass: float
) -> None:
    """Acting up to tau early it gives at most tau F_max (|N| + F_max)/m, and nothing without forces."""
    force = friction.force(StribeckState(), v, net, mass)
    limit, driving = friction.limit(v), abs(net) + friction.viscous * abs(v)
    bound = friction.stop_time * limit * (driving + limit) / mass
    assert (force - friction.viscous * v) * v >= -bound * (1.0 + 1e-9)


@given(friction=stribecks(), v=velocities, mass=masses)
def test_a_free_mass_is_never_sped_up(friction: Stribeck, v: float, mass: float) -> None:
    assert friction.force(StribeckState(), v, 0.0, mass) * v >= 0.0


def dissipated(friction: LuGre, z: float, v: float) -> float:
    """F v less what the bristles store, d(sigma_0 z^2/2)/dt."""
    state = LuGreState(z)
    bending = friction.deriv(state, v).deflection
    return friction.force(state, v, 0.0, 1.0) * v - friction.bristle_stiffness * z * bending


@given(friction=lugres(1.0), v=velocities, bent=st.floats(-1.0, 1.0))
def test_lugre_dissipates_up_to_its_passive_limit(friction: LuGre, v: float, bent: float) -> None:
    """sigma_1 (F_s - F_c) <= sigma_2 F_c, at every deflection that it can have."""
    z = bent * friction.breakaway / friction.bristle_stiffness
    scale = (friction.bristle_damping + friction.viscous) * v * v + friction.breakaway * abs(v)
    assert dissipated(friction, z, v) >= -1e-12 * scale


@given(friction=lugres(2.0))
def test_lugre_can_give_energy_beyond_it(friction: LuGre) -> None:
    """Fast motion on bristles bent as far as at rest: the limit is sharp."""
    z, v = friction.breakaway / friction.bristle_stiffness, 1e6
    assert dissipated(friction, z, v) < 0.0


@given(friction=lugres(1.0), v=velocities)
def test_bristles_bend_no_further_than_breakaway(friction: LuGre, v: float) -> None:
    z = friction.breakaway / friction.bristle_stiffness
    assert friction.deriv(LuGreState(z), v).deflection <= 1e-12 * abs(v)
    assert friction.deriv(LuGreState(-z), v).deflection >= -1e-12 * abs(v)


def test_the_defaults_are_passive() -> None:
    friction = example(LuGre)
    excess = friction.breakaway - friction.coulomb
    assert friction.bristle_damping * excess <= friction.viscous * friction.coulomb
