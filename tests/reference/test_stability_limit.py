"""The gain at which a slow valve makes PI control unstable: Routh's limit against simulation."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from hydroservo import Loop, Simulation, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.references import Step
from hydroservo.machine.loads import Constant
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.testing.examples import example

# Nominal values: Sec. 4 of doi:10.1007/s42401-021-00087-w
MASS, DAMPING, AREA, VOLUME, BULK, LEAKAGE = 6.0, 50.0, 4.91e-4, 8.74e-5, 7.0e8, 2.5e-11
DISCHARGE, GRADIENT, DENSITY, VALVE_GAIN, SUPPLY, LAG = 0.62, 0.024, 850.0, 5e-4, 40e5, 0.01
INTEGRAL_GAIN, PERIOD = 10.0, 2e-5
STEP = 1e-12  # [m/s] so small that the square root law is a straight line
STIFFNESS = 4.0 * BULK / VOLUME  # of the oil, dp/dV [Pa/m^3]
FLOW_GAIN = VALVE_GAIN * DISCHARGE * GRADIENT * math.sqrt(SUPPLY / DENSITY)  # at rest [m^3/(s V)]


def characteristic(gain: float) -> np.ndarray:
    """The polynomial of the loop linearised at rest: s (T s + 1) cylinder(s) + G (k_p s + k_i)."""
    cylinder = np.polyadd(
        np.polymul([1.0, DAMPING / MASS], [1.0, STIFFNESS * LEAKAGE]), [STIFFNESS * AREA**2 / MASS]
    )
    loop_gain = STIFFNESS * AREA * FLOW_GAIN / MASS
    return np.polyadd(np.polymul([LAG, 1.0, 0.0], cylinder), [loop_gain * gain, loop_gain * INTEGRAL_GAIN])


def growth(gain: float) -> float:
    """The real part of the oscillating pair of roots [1/s]."""
    roots = np.roots(characteristic(gain))
    return float(roots[roots.imag > 0.0].real.max())


@pytest.fixture(scope="module")
def limit() -> float:
    return float(brentq(growth, 1.0, 100.0, xtol=1e-9))


def test_routh_allows_8_4(limit: float) -> None:
    assert limit == pytest.approx(8.4, abs=0.1)
    assert growth(100.0) > 0.0  # the printed gain


def linear_force(gain: float, samples: int) -> np.ndarray:
    """The hydraulic force [N] of the sampled loop linearised at rest, exact at the samples."""
    machine = np.zeros((4, 4))  # velocity, force, opening, and the held command
    machine[0, :2] = -DAMPING / MASS, 1.0 / MASS
    machine[1, :3] = -STIFFNESS * AREA**2, -STIFFNESS * LEAKAGE, STIFFNESS * AREA * FLOW_GAIN / VALVE_GAIN
    machine[2, 2:] = -1.0 / LAG, VALVE_GAIN / LAG
    held = expm(machine * PERIOD)
    x, integral, force = np.zeros(3), 0.0, []
    for _ in range(samples):
        force.append(x[1])
        integral += PERIOD * INTEGRAL_GAIN * (STEP - x[0])
        x = held[:3] @ [*x, gain * (STEP - x[0]) + integral]
    return np.array(force)


def simulated_force(gain: float) -> np.ndarray:
    loop = example(
        Loop,
        simulation=Simulation(0.2, PERIOD, 1, PERIOD),
        valve=example(FirstOrderValve),
        controller=PI(gain, INTEGRAL_GAIN),
        reference=Step(0.0, STEP, 0.0),
        load=Constant(0.0),
    )
    return simulate(loop, record=["plant.hydraulic_force"])["plant.hydraulic_force"].values


@pytest.mark.parametrize("share", [0.8, 0.95, 1.05, 1.2])
def test_the_simulated_loop_decays_below_and_grows_above(limit: float, share: float) -> None:
    force = simulated_force(share * limit)
    second, last = (np.ptp(quarter) for quarter in np.array_split(force, 4)[1::2])
    assert (last > second) == (share > 1.0)
    expected = linear_force(share * limit, force.size)
    assert np.abs(force - expected).max() < 1e-6 * np.abs(expected).max()
