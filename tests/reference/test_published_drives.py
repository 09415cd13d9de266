"""Drives against results that others published."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo.core.signals import Feed, Pressures
from hydroservo.machine.drives import CheckValve, PumpDrive, PumpDriveState
from hydroservo.machine.valves import NoEdges

PSI = 6894.757  # Pa
REV = 2.0 * math.pi  # rad
DISPLACED, MOTOR = 5e-4 / REV, 5e-5 / REV  # [m^3/rad]
SPEED, INERTIA = 1000.0, 5.0  # [rad/s] of the pump, [kg m^2] at the motor
CHARGE, TANK = 3e6, 1e5  # [Pa]
HIGH, LOW = 1e9 / 1e-4, 1e9 / 1e-3  # [Pa/m^3] stiffness of the lines' oil
PUBLISHED = {  # time [s]: speed of the motor's shaft [rad/s]
    5.05: 3.69558,
    5.1: 6.63352,
    5.2: 10.9188,
    5.4: 17.0368,
    5.5: 19.1517,
    5.8: 21.2097,
    6.0: 21.4002,
    6.0562: 21.4048,  # its largest
    6.5: 21.2414,
    8.0: 20.6571,
    10.0: 20.279,
}


class TheirRelief(NamedTuple):
    """A relief valve in steady state, with flow forces and a largest opening, that lets off to the tank."""

    def flow(self, pressure: float) -> float:
        drop, rated = max(pressure + CHARGE - TANK, 0.0), math.sqrt(7e6)
        opening = (pressure + CHARGE - 2e7) / (rated / 1e-8 + drop / (1e-8 * rated))
        return min(max(opening, 0.0), 0.01 / rated) * math.sqrt(drop)


def test_a_hydrostatic_transmission_speeds_up_as_in_hopsan() -> None:
    """A pump of variable displacement at 1000 rad/s turns a motor, from rest to 20 rad/s by PI control.

    Numbers and result: "Hydrostatic Transmission" of Hopsan (its repository, Models/Example Models and their
    validations, commit 0c3995ee), whose own tolerance is 1 %. What a displacement does at constant speed, a
    speed does at constant displacement. Its check valves are turbulent, Q = 2.5e-5 sqrt(d); here they are
    laminar, of the same flow at what its relief valve lets off at first. Its relief valve is taken without
    its lag, which its method shortens; that is what the first half second differs by.
    """
    pump = PumpDrive(
        displacement=DISPLACED,
        command_gain=SPEED,
        max_speed=SPEED,
        speed_gain=1.0,
        max_torque=1.0,
        inertia=1.0,
        check_valve=CheckValve(cracking_pressure=0.0, conductance=2.3e-8),
        relief=TheirRelief(),
        leakage=1e-9,
    )
    feed = Feed(0.0, NoEdges(), 0.0, Pressures(CHARGE, TANK))

    def rates(t: float, x: list[float]) -> list[float]:
        a, b, speed, integral = x
        error = 20.0 - speed
        flows = pump.flows(PumpDriveState(SPEED * (0.05 * error + 0.02 * integral)), feed, a, b)
        taken = MOTOR * speed + 1e-11 * (a - b)
        return [HIGH * (flows.a - taken), LOW * (taken - flows.b), MOTOR * (a - b) / INERTIA, error]

    times = list(PUBLISHED)
    found = solve_ivp(rates, (5.0, 10.0), [1e7, 1e7, 0.0, 0.0], "Radau", times, rtol=1e-8, atol=1e-6)
    speeds = dict(zip(times, found.y[2], strict=True))
    for time, speed in PUBLISHED.items():
        assert speeds[time] == pytest.approx(speed, rel=8e-3 if time < 5.5 else 3e-3)
    assert np.max(found.y[2]) == pytest.approx(21.4048, rel=3e-4)
    assert speeds[10.0] == pytest.approx(20.279, rel=1e-4)


def test_a_pilot_opens_a_check_valve_as_a_trade_journal_has_it() -> None:
    """Ratio 4:1 and 3,000 psi to hold: just over 750 psi open it.

    B. Casey, The hydraulic equivalent of mechanical advantage, hydraulicsupermarket.com.
    """
    valve = CheckValve(cracking_pressure=0.0, conductance=1e-9, pilot_ratio=4.0)
    assert valve.piloted(-3000.0 * PSI, 750.0 * PSI) == 0.0
    assert valve.piloted(-3000.0 * PSI, 760.0 * PSI) < 0.0


@pytest.mark.parametrize(("ratio", "opens"), [(1.5, False), (3.0, True)])
def test_a_cylinder_of_two_to_one_needs_a_check_valve_of_three_to_one(ratio: float, opens: bool) -> None:
    """The pilot's pressure on the piston is twice as much at the rod: the same article."""
    valve = CheckValve(cracking_pressure=0.0, conductance=1e-9, pilot_ratio=ratio)
    assert all((valve.piloted(-2.0 * pilot, pilot) < 0.0) is opens for pilot in (1e6, 5e6, 20e6))
