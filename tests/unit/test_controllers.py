"""Each law: its output put into the model it was derived from gives the error dynamics it promises."""

from typing import Any, NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import ops
from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import PI, TSMC, Backstepping, PIState, Saturation
from hydroservo.control.observers import FilteredDerivative, ModelDerivative
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.papers.tsmc_eha_2021.printed import PrintedBackstepping, PrintedTSMC
from hydroservo.testing.examples import example

DT = 1e-4
MODEL = example(DesignModel)
NO_LIMIT = Saturation(1e300)

measurements = st.builds(
    Measurement, st.floats(-0.1, 0.1), st.floats(-500.0, 500.0), st.just(0.04), st.floats(-10.0, 10.0)
)
demands = st.builds(Demand, st.floats(-0.1, 0.1), st.floats(-1.0, 1.0), st.floats(-10.0, 10.0))


class Estimates(NamedTuple):
    s1: float
    s2: float
    d1: float
    d2: float
    velocity: float
    hydraulic_force: float


class Told(NamedTuple):
    """An observer that is told its answer."""

    s1: float
    s2: float
    d1: float
    d2: float

    def init(self) -> Estimates:
        return Estimates(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, s: Estimates, model: DesignModel, y: Measurement, dt: float) -> Estimates:
        return Estimates(self.s1, self.s2, self.d1, self.d2, y.velocity, y.hydraulic_force)


observers = st.builds(
    Told, st.floats(-1e-3, 1e-3), st.floats(-1.0, 1.0), st.floats(-20.0, 20.0), st.floats(-1e4, 1e4)
)


def after(block: Block, y: Measurement, r: Demand) -> Any:
    return block.step(block.init(), y, r, DT)


def test_pi_by_hand() -> None:
    block, r = PI(2.0, 30.0, controls=Velocity()), Demand(0.5, 0.0, 0.0)
    first = block.step(block.init(), Measurement(0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), r, 0.01)
    assert first == pytest.approx(PIState(2.0 * 0.4 + 0.12, 0.12, 2.0 * 0.4 + 0.12))
    second = block.step(first, Measurement(0.6, 0.0, 0.0, first.u, 0.0, 0.0, 0.0), r, 0.01)
    assert second.integral == pytest.approx(0.12 - 0.03)
    assert second.u == pytest.approx(-0.2 + 0.09)


def test_pi_winds_up_without_anti_windup_and_not_with_it() -> None:
    """One second at an error it cannot mend, then the error turns."""
    r = Demand(1.0, 0.0, 0.0)

    def samples_until_it_lets_go(block: PI) -> int:
        s, u = block.init(), 0.0
        for k in range(3000):
            velocity = 0.0 if k < 1000 else 2.0
            s = block.step(s, Measurement(velocity, 0.0, 0.0, u, 0.0, 0.0, 0.0), r, 1e-3)
            u = s.u
            if k >= 1000 and s.u < block.saturation.limit:
                return k - 1000
        raise AssertionError("never")

    assert samples_until_it_lets_go(PI(1.0, 20.0, 100.0, controls=Velocity())) <= 1
    assert samples_until_it_lets_go(PI(1.0, 20.0, 0.0, controls=Velocity())) == pytest.approx(
        450, abs=1
    )  # 9 V at 20 V/s


@given(y=measurements, r=demands)
def test_saturation_limits_every_law(y: Measurement, r: Demand) -> None:
    for law in (
        example(PI, 1e6, controls=Velocity()),
        example(Backstepping, model=MODEL),
        example(TSMC, model=MODEL),
    ):
        assert abs(after(law._replace(saturation=Saturation(0.5)), y, r).u) <= 0.5


@given(y=measurements, r=demands, k1=st.floats(1.0, 2000.0), k2=st.floats(1.0, 2000.0))
def test_backstepping_gives_its_error_dynamics_on_the_nominal_model(
    y: Measurement, r: Demand, k1: float, k2: float
) -> None:
    """dz1/dt = -k1 z1 + g1 z2 and dz2/dt = -k2 z2 - g1 z1 when there is no disturbance."""
    s = after(Backstepping(k1, k2, model=MODEL, saturation=NO_LIMIT), y, r)
    x1, x2, g1 = y.velocity, y.hydraulic_force, MODEL.g1()
    zeta = x2 - s.z2
    assert s.z1 == x1 - r.value
    assert zeta == pytest.approx((-k1 * s.z1 - MODEL.f1(x1) + r.rate) / g1, rel=1e-12, abs=1e-9)
    x1_rate = MODEL.f1(x1) + g1 * x2
    scale = k1 * (abs(s.z1) + 0.2) + g1 * 1000.0 + 10.0
    assert x1_rate - r.rate == pytest.approx(-k1 * s.z1 + g1 * s.z2, abs=1e-12 * scale)
    zeta_rate = (-k1 * (x1_rate - r.rate) - MODEL.f1(1.0) * x1_rate + r.second_rate) / g1
    x2_rate = MODEL.f2(x1, x2) + MODEL.g2(x2, y.command) * s.u
    terms = [MODEL.f2(x1, x2), zeta_rate, k2 * s.z2, g1 * s.z1]
    rounding = 1e-12 * (1.0 + sum(map(abs, terms)))
    assert x2_rate - zeta_rate == pytest.approx(-k2 * s.z2 - g1 * s.z1, abs=rounding)


@given(y=measurements, r=demands)
def test_printed_backstepping_takes_the_integral_of_the_demand_for_the_velocity(
    y: Measurement, r: Demand
) -> None:
    law = PrintedBackstepping()
    first = after(law, y, r)
    second = law.step(first, y, r, DT)
    assert first.z1 == y.velocity
    assert second.z1 == y.velocity - DT * r.value


@given(y=measurements, r=demands)
def test_the_filtered_derivative_serves_backstepping_too(y: Measurement, r: Demand) -> None:
    """Its first sample knows no rate, so the law differs from the analytic one by that term alone."""
    analytic = after(example(Backstepping, model=MODEL, saturation=NO_LIMIT), y, r)
    filtered = after(
        example(Backstepping, model=MODEL, derivative=FilteredDerivative(), saturation=NO_LIMIT), y, r
    )
    missing = analytic.derivative.rate / MODEL.g2(y.hydraulic_force, y.command)
    assert filtered.derivative.rate == 0.0
    assert analytic.u - filtered.u == pytest.approx(missing, rel=1e-9, abs=1e-9 * (1.0 + abs(analytic.u)))


@given(y=measurements, r=demands, told=observers)
def test_tsmc_gives_its_surface_dynamics_when_the_estimates_are_true(
    y: Measurement, r: Demand, told: Told
) -> None:
    """dxi2/dt = -mu2 xi2 - delta2 xi2^a2 for true, constant disturbances and surfaces at rest."""
    still = told._replace(s1=0.0, s2=0.0)
    law = example(TSMC, model=MODEL, observer=still, derivative=ModelDerivative(), saturation=NO_LIMIT)
    s = after(law, y, r)
    x1, x2, g1 = y.velocity, y.hydraulic_force, MODEL.g1()
    x1_rate = MODEL.f1(x1) + g1 * x2 + told.d1
    x2_rate = MODEL.f2(x1, x2) + MODEL.g2(x2, y.command) * s.u + told.d2
    xi1, xi1_rate = x1 - r.value, x1_rate - r.rate
    a1, a2 = law.exponent_1, law.exponent_2
    assert s.xi1 == xi1
    assert s.xi2 == pytest.approx(
        xi1_rate + law.linear_gain_1 * xi1 + law.power_gain_1 * ops.signed_power(xi1, a1), rel=1e-12, abs=1e-9
    )
    xi1_acceleration = MODEL.f1(1.0) * x1_rate + g1 * x2_rate - r.second_rate
    slope = a1 * (abs(xi1) + 1e-4) ** (a1 - 1.0)
    xi2_rate = xi1_acceleration + (law.linear_gain_1 + law.power_gain_1 * slope) * xi1_rate
    wanted = -law.linear_gain_2 * s.xi2 - law.power_gain_2 * ops.signed_power(s.xi2, a2)
    terms = [xi1_acceleration, law.linear_gain_1 * xi1_rate, g1 * MODEL.f2(x1, x2), wanted]
    assert xi2_rate == pytest.approx(wanted, abs=1e-11 * (1.0 + sum(map(abs, terms))))


@given(y=measurements, r=demands, told=observers)
def test_tsmc_surfaces_take_the_observers_in(y: Measurement, r: Demand, told: Told) -> None:
    """xi1 gains s1; xi2 gains what follows from it, and g1 s2 - b/m s1."""
    law = example(TSMC, model=MODEL, observer=told)
    s = after(law, y, r)
    xi1 = y.velocity - r.value + told.s1
    xi1_rate = MODEL.f1(y.velocity) + MODEL.g1() * y.hydraulic_force + told.d1 - r.rate
    power = ops.signed_power(xi1, law.exponent_1)
    expected = xi1_rate + law.linear_gain_1 * xi1 + law.power_gain_1 * power
    expected += MODEL.g1() * told.s2 + MODEL.f1(1.0) * told.s1
    assert s.xi1 == xi1
    assert s.xi2 == pytest.approx(expected, rel=1e-12, abs=1e-9)


@given(y=measurements, r=demands, told=observers)
def test_printed_tsmc_differs_where_the_print_does(y: Measurement, r: Demand, told: Told) -> None:
    """d1 for its rate, the second derivative of the demand for the third, s1 for xi1 in one power."""
    corrected = after(example(TSMC, model=MODEL, observer=told, saturation=NO_LIMIT), y, r)
    printed = after(PrintedTSMC(observer=told, saturation=NO_LIMIT), y, r)
    law = example(TSMC)
    xi1_rate = MODEL.f1(y.velocity) + MODEL.g1() * y.hydraulic_force + told.d1 - r.rate
    slope = law.exponent_1 * (abs(corrected.xi1) + 1e-4) ** (law.exponent_1 - 1.0)
    # the first sample of the filtered derivative knows no rate, neither of d1 nor of s1^a1
    more = told.d1 - (r.rate - r.second_rate) - law.power_gain_1 * slope * xi1_rate
    gain = MODEL.g1() * MODEL.g2(y.hydraulic_force, y.command)
    assert (printed.xi1, printed.xi2) == (corrected.xi1, corrected.xi2)
    assert printed.u - corrected.u == pytest.approx(
        -more / gain, rel=1e-9, abs=1e-11 * (1.0 + abs(printed.u))
    )
