"""The pump, its motor, the relief valve, the line and the accumulator."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from hydroservo import ParameterError
from hydroservo.core.signals import Pressures
from hydroservo.core.validation import checked
from hydroservo.machine.supplies import (
    GasAccumulator,
    IdealSupply,
    InstantPoppet,
    NoAccumulator,
    PumpSupply,
    PumpSupplyState,
    ReliefValve,
    SlowPoppet,
    SlowPoppetState,
)
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block

ATMOSPHERE = 101325.0


def delivered(supply: PumpSupply, s: PumpSupplyState) -> float:
    """What the pump and the relief valve leave for the line and the servo valve."""
    leaked = supply.leakage * (s.pressure - supply.return_pressure)
    return supply.displacement * s.speed - leaked - supply.relief.flow(s.pressure)


def followed(
    supply: PumpSupply, drawn: Callable[[float], float], duration: float, method: str = "LSODA"
) -> tuple[np.ndarray, ...]:
    """t, speed, pressure, and the integral of what was delivered less what was drawn."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        s = PumpSupplyState(y[0], y[1])
        return [*supply.deriv(s, drawn(t))[:2], 1e6 * (delivered(supply, s) - drawn(t))]

    start = [*supply.init()[:2], 0.0]
    found = solve_ivp(
        rates, (0.0, duration), start, method=method, rtol=1e-10, atol=1e-9, max_step=duration / 200
    )
    assert found.success
    return found.t, found.y[0], found.y[1], 1e-6 * found.y[2]


def test_a_relief_valve_opens_at_its_cracking_pressure() -> None:
    relief = ReliefValve(cracking_pressure=40e5, gradient=2e-10)
    assert relief.flow(10e5) == relief.flow(40e5) == 0.0
    assert relief.flow(43e5) == pytest.approx(2e-10 * 3e5, rel=1e-15)
    assert relief.flow(40e5 + 1e-3) < 1e-12


def test_the_design_model_sees_the_set_pressure() -> None:
    supply = example(PumpSupply, relief=example(ReliefValve, cracking_pressure=63e5), return_pressure=3e5)
    assert_same_block(supply.simplified(), IdealSupply(63e5, 3e5))


def test_the_design_model_sees_what_a_weak_motor_holds() -> None:
    supply = example(PumpSupply, leakage=0.0, max_torque=1.0)
    assert supply.simplified().supply_pressure == pytest.approx(2e5 + 1.0 / supply.displacement, rel=1e-12)


@pytest.mark.parametrize(
    "supply",
    [
        example(PumpSupply, demanded_speed=0.0),
        example(PumpSupply, relief=example(ReliefValve, cracking_pressure=2e5)),
        example(PumpSupply, relief=example(ReliefValve, cracking_pressure=1e5), return_pressure=3e5),
    ],
)
def test_it_holds_more_than_the_return_pressure(supply: PumpSupply) -> None:
    with pytest.raises(ParameterError, match=r"pressure = .* must be above return_pressure"):
        checked(supply)


def test_a_relief_valve_from_its_override() -> None:
    relief = ReliefValve.from_override(cracking_pressure=63e5, override=4e5, flow=2e-4)
    assert relief.flow(63e5) == 0.0
    assert relief.flow(67e5) == pytest.approx(2e-4, rel=1e-12)


@pytest.mark.parametrize(("override", "flow", "name"), [(0.0, 1e-4, "override"), (1e5, -1e-4, "flow")])
def test_a_relief_valve_opens_with_pressure(override: float, flow: float, name: str) -> None:
    with pytest.raises(ParameterError, match=f"{name} = .*: must be above 0"):
        ReliefValve.from_override(40e5, override, flow)


@pytest.mark.parametrize("efficiency", [0.9, 1.0])
def test_a_pump_from_its_datasheet_settles_at_its_rated_point(efficiency: float) -> None:
    """A stiff line held at the rated pressure above the return."""
    rated = PumpSupply.from_datasheet(
        3e-7,
        150.0,
        efficiency,
        60e5,
        4.0,
        2e-3,
        2e-4,
        7e8,
        example(ReliefValve, 80e5),
        speed_gain=1.0,
        viscous=2e-3,
        return_pressure=2e5,
    )
    pressure = rated.return_pressure + 60e5
    found = solve_ivp(
        lambda _, y: [rated.deriv(PumpSupplyState(y[0], pressure), 0.0).speed],
        (0.0, 0.2),
        [0.0],
        method="LSODA",
        rtol=1e-10,
        atol=1e-9,
    )
    assert found.y[0, -1] == pytest.approx(150.0, rel=1e-8)
    state = PumpSupplyState(float(found.y[0, -1]), pressure)
    assert delivered(rated, state) == pytest.approx(efficiency * 3e-7 * 150.0, rel=1e-7)


def test_a_datasheet_s_pump_keeps_its_other_parts() -> None:
    gas, relief = GasAccumulator(28e5, 5e-4), example(ReliefValve, 63e5)
    supply = PumpSupply.from_datasheet(
        3e-7, 150.0, 0.9, 60e5, 4.0, 1e-3, 3e-4, 8e8, relief, 1.0, accumulator=gas
    )
    assert (supply.volume, supply.relief, supply.accumulator) == (3e-4, relief, gas)
    assert (supply.inertia, supply.bulk_modulus) == (1e-3, 8e8)


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"max_torque": 1.7}, r"max_torque = 1.7: must be at least 1.95 \[N m\]"),
        ({"volumetric_efficiency": 1.01}, "volumetric_efficiency = 1.01: must be in"),
        ({"volumetric_efficiency": 0.0}, "volumetric_efficiency = 0.0: must be in"),
        ({"rated_pressure": 0.0}, "rated_pressure = 0.0: must be above 0"),
        ({"rated_speed": -1.0}, "rated_speed = -1.0: must be above 0"),
    ],
)
def test_a_datasheet_that_no_pump_has(changed: dict[str, float], problem: str) -> None:
    given = {
        "displacement": 3e-7,
        "rated_speed": 150.0,
        "volumetric_efficiency": 0.9,
        "rated_pressure": 60e5,
        "max_torque": 4.0,
        "inertia": 2e-3,
        "volume": 2e-4,
        "bulk_modulus": 7e8,
        "relief": example(ReliefValve, 40e5),
        "speed_gain": 1.0,
        "viscous": 1e-3,
    }
    with pytest.raises(ParameterError, match=problem):
        PumpSupply.from_datasheet(**{**given, **changed})


def test_pressures_are_those_of_the_line_and_the_return() -> None:
    assert example(PumpSupply).pressures(PumpSupplyState(10.0, 33e5)) == Pressures(33e5, 2e5)


supplies = st.builds(
    lambda torque, speed, gain, viscous, leakage, crack, gradient: example(
        PumpSupply,
        max_torque=torque,
        demanded_speed=speed,
        speed_gain=gain,
        viscous=viscous,
        leakage=leakage,
        relief=ReliefValve(crack, gradient),
    ),
    st.floats(0.1, 10.0),
    st.floats(0.0, 300.0),
    st.floats(0.05, 5.0),
    st.one_of(st.just(0.0), st.floats(1e-4, 1e-2)),
    st.one_of(st.just(0.0), st.floats(1e-13, 1e-11)),
    st.floats(3e5, 200e5),
    st.floats(1e-11, 1e-8),
)


@given(supply=supplies)
def test_it_starts_steady_with_the_valve_shut(supply: PumpSupply) -> None:
    start = supply.init()
    rates = supply.deriv(start, 0.0)
    flow, torque = supply.displacement * max(start.speed, 1.0), supply.max_torque
    assert rates.pressure * supply.line_compliance(start.pressure) == pytest.approx(0.0, abs=1e-9 * flow)
    assert rates.speed * supply.inertia == pytest.approx(0.0, abs=1e-9 * torque)
    assert start.pressure >= supply.return_pressure


def test_the_steady_pressure_is_where_the_relief_valve_takes_all() -> None:
    """Without leakage and friction, from D w = G (p - p_c) and D (p - p_r) = K (w_ref - w)."""
    supply = example(PumpSupply, leakage=0.0, viscous=0.0)
    d, g, k = supply.displacement, supply.relief.gradient, supply.speed_gain
    matrix = [[d, -g], [k, d]]
    wanted = np.linalg.solve(
        matrix, [-g * supply.relief.cracking_pressure, k * supply.demanded_speed + d * supply.return_pressure]
    )
    assert supply.init()[:2] == pytest.approx(tuple(wanted), rel=1e-12)


def test_a_weak_motor_stalls_at_the_pressure_that_its_torque_holds() -> None:
    supply = example(PumpSupply, leakage=0.0, max_torque=1.0)
    start = supply.init()
    assert start.pressure == pytest.approx(supply.return_pressure + 1.0 / supply.displacement, rel=1e-12)
    assert start.speed == 0.0


@pytest.mark.parametrize("load", [10e5, 30e5])
def test_the_speed_droops_under_load(load: float) -> None:
    """A stiff line at a pressure: the shaft settles where the torques balance."""
    supply = example(PumpSupply)
    pressure = supply.return_pressure + load
    found = solve_ivp(
        lambda _, y: [supply.deriv(PumpSupplyState(y[0], pressure), 0.0).speed],
        (0.0, 0.2),
        [supply.demanded_speed],
        method="LSODA",
        rtol=1e-10,
        atol=1e-9,
    )
    load_torque = supply.displacement * load + supply.viscous * supply.demanded_speed
    droop = load_torque / (supply.speed_gain + supply.viscous)
    assert supply.demanded_speed - found.y[0, -1] == pytest.approx(droop, rel=1e-6)


def test_the_motor_has_a_largest_torque() -> None:
    supply = example(PumpSupply, viscous=0.0, max_torque=3.0)
    for side in (-1.0, 1.0):
        start = PumpSupplyState(supply.demanded_speed - side * 100.0, supply.return_pressure)
        assert supply.deriv(start, 0.0).speed == pytest.approx(side * 3.0 / supply.inertia, rel=1e-15)


def volume_in_line(supply: PumpSupply, pressure: np.ndarray) -> np.ndarray:
    """What has entered the line since p = 0, from the laws of its oil, its air and its gas."""
    absolute = pressure + ATMOSPHERE
    air = supply.free_air * supply.volume * (1.0 - ATMOSPHERE / absolute)
    return supply.volume * pressure / supply.bulk_modulus + air + gas_squeezed(supply.accumulator, absolute)


def gas_squeezed(accumulator: object, absolute: np.ndarray) -> np.ndarray:
    """The oil in an accumulator: the gas volume that is missing."""
    if not isinstance(accumulator, GasAccumulator):
        return np.zeros_like(absolute)
    precharge = accumulator.precharge + ATMOSPHERE
    volume = (precharge / np.maximum(absolute, precharge)) ** (1.0 / accumulator.exponent)
    return accumulator.gas_volume * (1.0 - volume)


def test_the_line_loses_no_oil() -> None:
    """What was delivered less what was drawn is what the line holds more, through full and empty."""
    supply = example(PumpSupply, accumulator=NoAccumulator())
    _, _, pressure, balance = followed(supply, lambda t: 5e-5 + 2.5e-4 * math.sin(30.0 * t), 0.4)
    held = volume_in_line(supply, pressure)
    assert pressure.min() < 1e5
    assert pressure.max() > supply.relief.cracking_pressure
    assert held - held[0] == pytest.approx(balance, abs=1e-7 * np.ptp(balance) + 1e-13)


def test_an_accumulator_gives_its_oil_by_the_polytropic_law() -> None:
    """While it feeds the valve alone, from a line next to nothing, p V^n is constant."""
    gas = GasAccumulator(precharge=25e5, gas_volume=2e-4, exponent=1.3)
    supply = example(PumpSupply, accumulator=gas, leakage=0.0, volume=1e-10)
    drawn, start = 1e-5, 39e5
    found = solve_ivp(
        lambda _, y: [supply.deriv(PumpSupplyState(0.0, y[0]), drawn).pressure],
        (0.0, 5.0),
        [start],
        rtol=1e-11,
        atol=1e-3,
    )
    absolute = found.y[0] + ATMOSPHERE
    volume = gas.gas_volume * ((25e5 + ATMOSPHERE) / (39e5 + ATMOSPHERE)) ** (1.0 / 1.3) + drawn * found.t
    assert 27e5 < absolute[-1] < 29e5
    assert absolute * volume**1.3 == pytest.approx((25e5 + ATMOSPHERE) * gas.gas_volume**1.3, rel=1e-6)


def test_an_accumulator_does_the_work_of_its_gas() -> None:
    """The integral of p dV_oil is the work of a polytropic change of state."""
    gas = GasAccumulator(precharge=25e5, gas_volume=2e-4, exponent=1.3)
    pressure = np.linspace(25e5 + 1.0, 80e5, 20001)
    absolute = pressure + ATMOSPHERE
    compliance = np.array([gas.compliance(float(p)) for p in pressure])
    work = float(np.trapezoid(absolute * compliance, pressure))
    p0, p1 = absolute[0], absolute[-1]
    v0 = gas.gas_volume
    v1 = v0 * (p0 / p1) ** (1.0 / 1.3)
    assert work == pytest.approx((p1 * v1 - p0 * v0) / (1.3 - 1.0), rel=1e-6)


def test_below_its_precharge_an_accumulator_holds_no_oil() -> None:
    assert GasAccumulator(30e5, 5e-4).compliance(29.9e5) == 0.0
    isothermal = GasAccumulator(precharge=30e5, gas_volume=1e-3, exponent=1.0)
    assert isothermal.compliance(61e5) == pytest.approx(
        1e-3 * (30e5 + ATMOSPHERE) / (61e5 + ATMOSPHERE) ** 2, rel=1e-14
    )
    assert NoAccumulator().compliance(100e5) == 0.0


@pytest.mark.parametrize("drawn", [2e-4, 5e-3])
def test_no_draught_takes_the_line_below_a_vacuum(drawn: float) -> None:
    _, _, pressure, _ = followed(example(PumpSupply), lambda _: drawn, 0.5)
    assert -ATMOSPHERE < pressure.min() < 0.0


def test_the_line_s_stiffness_is_that_of_oil_and_air() -> None:
    supply = example(PumpSupply, volume=1e-3, bulk_modulus=1e9, free_air=0.01)
    wanted = 1e-3 / 1e9 + 1e-3 * 0.01 * ATMOSPHERE / (20e5 + ATMOSPHERE) ** 2
    assert supply.line_compliance(20e5) == pytest.approx(wanted, rel=1e-14)


class TestSlowPoppet:
    supply = example(PumpSupply, poppet=SlowPoppet(4e-3), return_pressure=0.0)

    @given(override=st.floats(0.0, 50e5))
    def test_settled_it_passes_what_the_valve_s_curve_says(self, override: float) -> None:
        poppet, relief = self.supply.poppet, self.supply.relief
        pressure = relief.cracking_pressure + override
        s = poppet.steady_at(relief, pressure)
        assert poppet.flow(s, relief, pressure) == pytest.approx(relief.flow(pressure), rel=1e-9, abs=1e-20)
        assert poppet.deriv(s, relief, pressure).override == 0.0

    def test_it_starts_at_rest_where_a_quick_one_does(self) -> None:
        start = self.supply.init()
        assert start[:2] == self.supply._replace(poppet=InstantPoppet()).init()[:2]
        assert start.poppet.override == start.pressure - self.supply.relief.cracking_pressure
        speed, pressure, _ = self.supply.deriv(start, 0.0)
        assert (speed, pressure) == pytest.approx((0.0, 0.0), abs=1e-3)

    def test_it_opens_with_its_lag(self) -> None:
        relief = self.supply.relief
        pressure = relief.cracking_pressure + 8e5
        found = solve_ivp(
            lambda _, y: [self.supply.poppet.deriv(SlowPoppetState(y[0]), relief, pressure).override],
            *((0.0, 8e-3), [0.0]),
            rtol=1e-10,
        )
        assert found.y[0, -1] == pytest.approx(8e5 * -math.expm1(-2.0), rel=1e-8)

    def test_no_oil_comes_back_through_it(self) -> None:
        poppet, relief = self.supply.poppet, self.supply.relief
        assert poppet.flow(SlowPoppetState(5e5), relief, -9e4) == 0.0
        assert poppet.flow(SlowPoppetState(-1.0), relief, 50e5) == 0.0
        assert poppet.deriv(SlowPoppetState(5e5), relief, 0.0).override == pytest.approx(-5e5 / 4e-3)

    def test_the_line_swings_on_it(self) -> None:
        """At a steady delivery, s^2 + (1/T + Q_p/C) s + (Q_p + Q_y)/(C T) = 0, with the slopes of Q."""
        supply, start = self.supply, self.supply.init()
        pressure, override = start.pressure, start.poppet.override

        def rates(dp: float, dy: float) -> list[float]:
            s = PumpSupplyState(start.speed, pressure + dp, SlowPoppetState(override + dy))
            rate = supply.deriv(s, 0.0)
            leaked = supply.leakage * dp / supply.line_compliance(pressure + dp)
            return [rate.pressure + leaked, rate.poppet.override]

        h = 1.0
        columns = [np.subtract(rates(h, 0.0), rates(-h, 0.0)), np.subtract(rates(0.0, h), rates(0.0, -h))]
        matrix = np.array(columns).T / (2.0 * h)
        c, lag = supply.line_compliance(pressure), 4e-3
        by_pressure = 0.5 * supply.relief.flow(pressure) / pressure
        by_opening = supply.relief.gradient - by_pressure
        wanted = np.roots([1.0, 1.0 / lag + by_pressure / c, (by_pressure + by_opening) / (c * lag)])
        assert sorted(np.linalg.eigvals(matrix), key=lambda z: z.imag) == pytest.approx(
            sorted(wanted, key=lambda z: z.imag), rel=1e-4
        )


def test_a_return_line_may_be_below_the_atmosphere() -> None:
    supply = checked(example(PumpSupply, return_pressure=-0.5e5))
    assert supply.init().pressure > supply.return_pressure
    assert checked(IdealSupply(40e5, -0.9e5)).drop() == 40.9e5
    with pytest.raises(ParameterError, match=r"return_pressure = -120000\.0: must be .* above -1013"):
        checked(IdealSupply(40e5, -1.2e5))
