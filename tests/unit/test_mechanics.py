"""Frictions, end stops and mechanisms against their equations."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.core.block import Block
from hydroservo.core.errors import ParameterError
from hydroservo.core.validation import checked
from hydroservo.machine.mechanics import (
    Contact,
    ElastoPlastic,
    LuGre,
    LuGreState,
    Mass,
    MassSpringDamper,
    NoStops,
    OneLinkArm,
    Stops,
    Stribeck,
    Viscous,
)
from hydroservo.machine.plants import Cylinder
from hydroservo.testing.examples import example

velocities = st.floats(-1.0, 1.0)
forces = st.floats(-1e4, 1e4)
ARM = example(OneLinkArm, level_angle=1.2)


def hinge_angle(arm: OneLinkArm, x: float) -> float:
    """The angle opposite to the cylinder in the triangle."""
    a, b, length = arm.base_distance, arm.pin_distance, arm.closed_length + x
    return math.acos((a * a + b * b - length * length) / (2.0 * a * b))


def test_viscous() -> None:
    friction = Viscous(30.0)
    assert friction.force(friction.init(), 0.2, 1e3, 5.0) == 6.0
    assert friction.simplified() == 30.0


class TestStribeck:
    friction = Stribeck(40.0, 60.0, 5e-3, 50.0, 1e-4)

    def force(self, velocity: float, net: float, mass: float = 6.0) -> float:
        return self.friction.force(self.friction.init(), velocity, net, mass)

    @given(net=st.floats(-60.0, 60.0))
    def test_at_rest_it_balances_what_it_can_hold(self, net: float) -> None:
        assert self.force(0.0, net) == net

    @given(net=st.floats(60.0, 1e4))
    def test_at_rest_it_gives_way_beyond_the_breakaway_force(self, net: float) -> None:
        assert self.force(0.0, net) == 60.0
        assert self.force(0.0, -net) == -60.0

    @given(v=st.floats(1e-6, 1.0))
    def test_steady_sliding_meets_the_stribeck_curve(self, v: float) -> None:
        """The force that keeps a velocity, F(v, N = F), is that of Hess and Soom."""
        curve = 50.0 * v + 40.0 + 20.0 / (1.0 + (v / 5e-3) ** 2)
        assert self.force(v, curve) == pytest.approx(curve, rel=1e-12)
        assert self.force(-v, -curve) == pytest.approx(-curve, rel=1e-12)

    @given(v=st.floats(-1e-5, 1e-5), net=st.floats(-50.0, 50.0))
    def test_a_slow_mass_is_stopped_in_the_stop_time(self, v: float, net: float) -> None:
        rate = (net - self.force(v, net)) / 6.0
        assert rate == pytest.approx(-v / 1e-4, rel=1e-9, abs=1e-13)

    def test_simplified(self) -> None:
        assert self.friction.simplified() == 50.0


class TestLuGre:
    friction = LuGre(1e6, 80.0, 40.0, 60.0, 5e-3, 50.0)

    def test_equations(self) -> None:
        v, z = 4e-3, 3e-5
        g = 40.0 + 20.0 * math.exp(-((4.0 / 5.0) ** 2))
        bending = v - 1e6 * v / g * z
        state = LuGreState(z)
        assert self.friction.deriv(state, v).deflection == pytest.approx(bending, rel=1e-13)
        expected = 1e6 * z + 80.0 * bending + 50.0 * v
        assert self.friction.force(state, v, 1e3, 6.0) == pytest.approx(expected, rel=1e-13)

    def test_it_starts_unbent(self) -> None:
        assert self.friction.init() == LuGreState(0.0)
        assert self.friction.simplified() == 50.0


class TestElastoPlastic:
    bristles = LuGre(1e6, 80.0, 40.0, 60.0, 5e-3, 50.0)
    friction = ElastoPlastic(bristles, 0.8)

    def test_equations(self) -> None:
        """In between, where a = 1/2 at q = 0.9."""
        v = 4e-3
        g = 40.0 + 20.0 * math.exp(-((4.0 / 5.0) ** 2))
        state = LuGreState(0.9 * g / 1e6)
        bending = v - 0.5 * 0.9 * v
        assert self.friction.deriv(state, v).deflection == pytest.approx(bending, rel=1e-12)
        expected = 0.9 * g + 80.0 * bending + 50.0 * v
        assert self.friction.force(state, v, 1e3, 6.0) == pytest.approx(expected, rel=1e-12)

    @given(z=st.floats(-47e-6, 47e-6), v=st.floats(-1e-4, 1e-4))
    def test_within_its_elastic_range_it_is_a_spring(self, z: float, v: float) -> None:
        assert self.friction.deriv(LuGreState(z), v).deflection == v

    @given(z=st.floats(1e-7, 1e-3), v=st.floats(1e-6, 1.0))
    def test_what_unbends_it_is_a_spring(self, z: float, v: float) -> None:
        assert self.friction.deriv(LuGreState(z), -v).deflection == -v

    @given(v=st.floats(1e-6, 1.0), beyond=st.floats(1.0, 2.0))
    def test_beyond_sliding_it_is_lugre(self, v: float, beyond: float) -> None:
        state = LuGreState(beyond * self.bristles.sliding(v) / 1e6)
        assert self.friction.deriv(state, v).deflection == pytest.approx(
            self.bristles.deriv(state, v).deflection, rel=1e-9, abs=1e-12 * v
        )


class TestStops:
    stops = Stops(1e8, 5.0)

    @given(x=st.floats(0.0, 0.08), v=velocities)
    def test_inside_the_stroke_there_is_no_force(self, x: float, v: float) -> None:
        assert self.stops.force(x, v, 0.08) == 0.0

    def test_beyond_the_ends(self) -> None:
        assert self.stops.force(-1e-4, -0.1, 0.08) == pytest.approx(1e8 * 1e-4 * 1.5)
        assert self.stops.force(0.08 + 1e-4, 0.1, 0.08) == pytest.approx(-1e8 * 1e-4 * 1.5, rel=1e-9)

    @given(depth=st.floats(0.0, 1e-3), v=velocities)
    def test_they_push_and_never_pull(self, depth: float, v: float) -> None:
        assert self.stops.force(-depth, v, 0.08) >= 0.0
        assert self.stops.force(0.08 + depth, v, 0.08) <= 0.0

    def test_no_stops(self) -> None:
        assert NoStops().force(-1.0, 2.0, 0.08) == 0.0


def test_mass() -> None:
    assert Mass(4.0).inertia(0.02) == 4.0
    assert Mass(4.0).resistance(0.02, 0.1) == 0.0


@pytest.mark.parametrize("rise", [1.0, -1.0, 0.5])
def test_a_mass_on_a_slope_weighs_what_its_rise_says(rise: float) -> None:
    assert Mass(4.0, rise).resistance(0.02, 0.1) == pytest.approx(4.0 * 9.80665 * rise, rel=1e-15)
    assert Mass(4.0, rise, gravity=1.62).resistance(0.02, 0.1) == pytest.approx(6.48 * rise, rel=1e-15)
    across, up, *rest = Mass(4.0, rise).tip(0.02)
    assert (math.hypot(across, up), up, *rest) == (1.0, rise, 0.0, 0.0, 0.0)


def test_on_the_moon_an_arm_weighs_a_sixth() -> None:
    moon = ARM._replace(gravity=9.80665 / 6.0)
    assert moon.resistance(0.02, 0.0) == pytest.approx(ARM.resistance(0.02, 0.0) / 6.0, rel=1e-14)
    assert moon.inertia(0.02) == ARM.inertia(0.02)


def test_mass_spring_damper() -> None:
    load = MassSpringDamper(4.0, 1e4, 0.03, 20.0)
    assert load.inertia(0.1) == 4.0
    assert load.resistance(0.05, 0.1) == pytest.approx(1e4 * 0.02 + 20.0 * 0.1)
    assert load.tip(0.05) == Mass(4.0).tip(0.02) == (1.0, 0.0, 0.0, 0.0, 0.0)


class TestOneLinkArm:
    positions = np.linspace(0.0, 0.078, 7).tolist()

    @pytest.mark.parametrize("x", positions)
    def test_inertia(self, x: float) -> None:
        """dq/dx by a difference of the angle itself."""
        h = 1e-6
        turning = (hinge_angle(ARM, x + h) - hinge_angle(ARM, x - h)) / (2.0 * h)
        expected = 1.0 + (0.25 + 3.0 * 0.36) * turning**2
        assert ARM.inertia(x) == pytest.approx(expected, rel=1e-8)

    @pytest.mark.parametrize("x", positions)
    def test_a_changing_inertia_resists(self, x: float) -> None:
        """(1/2) dM/dx v^2, by a difference of M."""
        h, v = 1e-6, 0.3
        slope = (ARM.inertia(x + h) - ARM.inertia(x - h)) / (2.0 * h)
        found = ARM.resistance(x, v) - ARM.resistance(x, 0.0)
        assert found == pytest.approx(0.5 * slope * v * v, rel=1e-6, abs=1e-6)

    @pytest.mark.parametrize("x", positions)
    def test_it_holds_the_weight(self, x: float) -> None:
        """Statics: moments about the hinge, in the plane with the level link along the first axis."""
        arm = ARM
        q = hinge_angle(arm, x)
        link = np.array([math.cos(q - arm.level_angle), math.sin(q - arm.level_angle)])
        base = np.array([math.cos(-arm.level_angle), math.sin(-arm.level_angle)]) * arm.base_distance
        pin = arm.pin_distance * link
        along = (pin - base) / np.linalg.norm(pin - base)
        lever = float(pin[0] * along[1] - pin[1] * along[0])
        weight = 9.80665 * (arm.arm_mass * arm.centre_distance + arm.payload * arm.reach) * float(link[0])
        assert arm.resistance(x, 0.0) == pytest.approx(weight / lever, rel=1e-11)

    @pytest.mark.parametrize("x", [-0.0515, 0.1085, -1.0, 1.0])
    def test_dead_points_leave_it_finite(self, x: float) -> None:
        assert math.isfinite(ARM.inertia(x))
        assert math.isfinite(ARM.resistance(x, 0.1))


@pytest.mark.parametrize(
    "friction", [example(Viscous), example(Stribeck), example(LuGre), example(ElastoPlastic)]
)
@given(v=velocities, net=forces)
def test_friction_is_odd(friction: Block, v: float, net: float) -> None:
    there = friction.force(friction.init(), v, net, 6.0)
    assert friction.force(friction.init(), -v, -net, 6.0) == -there


class TestContact:
    contact = Contact(Mass(5.0, rise=1.0), position=0.1, stiffness=1e6, dissipation=2.0)

    def test_the_force_adds_to_the_mechanism_and_never_pulls(self) -> None:
        weight = Mass(5.0, rise=1.0).resistance(0.0, 0.0)
        assert self.contact.resistance(0.1, 0.3) == weight
        assert self.contact.resistance(0.102, 0.1) == pytest.approx(weight + 2e3 * 1.2)
        assert self.contact.resistance(0.102, -0.7) == weight
        assert self.contact.inertia(0.2) == 5.0

    @pytest.mark.parametrize("speed", [0.05, 0.2])
    def test_a_free_mass_bounces_as_from_the_stops(self, speed: float) -> None:
        """Of Stops' docstring: c v_i - ln(1 + c v_i) = -c v_o - ln(1 - c v_o), by bisection."""
        contact = self.contact._replace(mechanism=Mass(5.0))
        x, v, dt = 0.1, speed, 1e-7
        while x >= 0.1:
            a = -contact.resistance(x + 0.5 * dt * v, v) / 5.0
            v, x = v + dt * a, x + dt * (v + 0.5 * dt * a)
        c, low, high = 2.0, 0.0, speed
        lost = c * speed - math.log1p(c * speed)
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if -c * middle - math.log1p(-c * middle) < lost else (low, middle)
        assert -v == pytest.approx(low, rel=1e-4)

    @pytest.mark.parametrize("position", [0.02, 0.3])
    def test_a_contact_at_the_start_or_beyond_the_stroke_is_refused(self, position: float) -> None:
        with pytest.raises(ParameterError, match=r"from the start, 0.039.*below the stroke, 0.078"):
            checked(example(Cylinder, mechanism=self.contact._replace(position=position)))

    def test_it_passes_on_what_its_mechanism_has(self) -> None:
        on_arm = self.contact._replace(mechanism=ARM)
        assert on_arm.tip(0.05) == ARM.tip(0.05)
        assert on_arm.positions() == ARM.positions()
        assert self.contact.positions() == (-math.inf, math.inf)
