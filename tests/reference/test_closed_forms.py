"""The machine's figures against closed forms, worked out apart from the code."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import fsolve

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.controllers.pi import PIState
from hydroservo.control.loop import MachineState
from hydroservo.core.signals import Demand, Measurement, PortFlows
from hydroservo.machine.drives import ValveOnSupplyState
from hydroservo.machine.loads import Constant
from hydroservo.machine.plants import DesignModel, LoadPressurePlant, LoadPressureState
from hydroservo.machine.supplies import IdealSupplyState
from hydroservo.machine.valves import Orifice, StaticValveState
from hydroservo.testing.examples import example

# Nominal values and uncertainties: Sec. 4 of doi:10.1007/s42401-021-00087-w
MASS, DAMPING, AREA, VOLUME, BULK, LEAKAGE = 6.0, 50.0, 4.91e-4, 8.74e-5, 7.0e8, 2.5e-11
DISCHARGE, GRADIENT, DENSITY, VALVE_GAIN, SUPPLY = 0.62, 0.024, 850.0, 5e-4, 40e5
UPWARD = {
    "valve.orifice.discharge_coefficient": 1.1 * DISCHARGE,
    "valve.orifice.area_gradient": 1.1 * GRADIENT,
    "valve.orifice.density": 1.15 * DENSITY,
    "plant.leakage": 1.3 * LEAKAGE,
    "plant.bulk_modulus": 1.1 * BULK,
    "plant.damping": 1.2 * DAMPING,
}
CLOSED = PortFlows(0.0, 0.0, 0.0, 0.0)


class NominalState(NamedTuple):
    u: float
    d1: float
    d2: float
    controller: PIState


class Nominal(NamedTuple):
    """A PI with the nominal model, against which disturbances are counted, and estimates that are 0."""

    controller: PI = PI(0.3, 100.0)
    model: DesignModel = example(DesignModel)

    def init(self) -> NominalState:
        return NominalState(0.0, 0.0, 0.0, self.controller.init())

    def step(self, s: NominalState, y: Measurement, r: Demand, dt: float) -> NominalState:
        own = self.controller.step(s.controller, y, r, dt)
        return NominalState(own.u, 0.0, 0.0, own)


STIFFNESS = 4.0 * BULK * AREA**2 / VOLUME  # [N/m]


def jacobian(plant: LoadPressurePlant) -> np.ndarray:
    """d(rates)/d(velocity, hydraulic force) of a free plant, by central differences; the plant is linear."""

    def rates(velocity: float, force: float) -> np.ndarray:
        return np.array(plant.deriv(LoadPressureState(velocity, force, 0.0), CLOSED, 0.0)[:2])

    by_velocity = (rates(1e-2, 0.0) - rates(-1e-2, 0.0)) / 2e-2
    by_force = (rates(0.0, 10.0) - rates(0.0, -10.0)) / 20.0
    return np.column_stack([by_velocity, by_force])


@pytest.mark.parametrize(("leakage", "printed_ratio"), [(LEAKAGE, 0.356), (LEAKAGE * AREA, 0.004)])
def test_natural_frequency_and_damping_ratio(leakage: float, printed_ratio: float) -> None:
    eigenvalues = np.linalg.eigvals(jacobian(example(LoadPressurePlant, leakage=leakage)))
    frequency, ratio = abs(eigenvalues[0]), -eigenvalues[0].real / abs(eigenvalues[0])
    decay = 4.0 * BULK / VOLUME * leakage  # [1/s]
    exact = math.sqrt(STIFFNESS / MASS + decay * DAMPING / MASS)
    assert frequency == pytest.approx(exact, rel=1e-9)
    assert ratio == pytest.approx((decay + DAMPING / MASS) / (2.0 * exact), rel=1e-9)
    assert math.sqrt(STIFFNESS / MASS) == pytest.approx(1135.0, rel=5e-4)
    assert frequency == pytest.approx(1135.0, rel=3e-3)
    assert ratio == pytest.approx(printed_ratio, abs=5e-4)


def test_steady_velocity_gain_near_rest() -> None:
    loop, u = example(Loop, load=Constant(0.0)), 1e-6

    def rates(x: np.ndarray) -> list[float]:
        plant = LoadPressureState(*(x * u).tolist(), 0.0)
        rate = loop.deriv(
            0.0, MachineState(plant, StaticValveState(), IdealSupplyState(), ValveOnSupplyState()), u
        ).plant
        return [rate.velocity, rate.hydraulic_force]

    gain = fsolve(rates, [1.0, 1.0], xtol=1e-12)[0]
    flow_gain = DISCHARGE * GRADIENT * VALVE_GAIN * math.sqrt(SUPPLY / DENSITY)
    assert gain == pytest.approx(flow_gain / (AREA + LEAKAGE * DAMPING / AREA), rel=1e-6)
    assert flow_gain / AREA == pytest.approx(1.04, abs=0.005)
    assert gain == pytest.approx(1.04, rel=0.01)


def test_rated_flow_is_that_of_two_equal_edges_in_series() -> None:
    opening, drop = 5e-3, 40e5
    one_edge = DISCHARGE * GRADIENT * opening * math.sqrt(2.0 * (0.5 * drop) / DENSITY)
    assert example(Orifice).flow(opening, drop, 0.0) == pytest.approx(one_edge, rel=1e-14)
    assert one_edge * 6e4 == pytest.approx(306.2, abs=0.1)  # [L/min]


def test_half_the_supply_at_the_load_costs_a_factor_of_root_two() -> None:
    free, loaded = example(Orifice).flow(1e-3, 40e5, 0.0), example(Orifice).flow(1e-3, 40e5, 20e5)
    assert loaded == pytest.approx(free / math.sqrt(2.0), rel=1e-14)


def test_a_load_of_100_newton_is_a_disturbance_of_16_7() -> None:
    """d_L1 = -(F_L + Delta b x1)/m, eq. (6); the nominal machine has nothing else."""
    loop = example(
        Loop, simulation=Simulation(0.01, 1e-4, 1, 1e-4), load=Constant(100.0), controller=Nominal()
    )
    run = simulate(loop)
    assert run["disturbance.d1"].values == pytest.approx(-100.0 / MASS, abs=1e-9)
    assert float(run.disturbance_max_1) == pytest.approx(16.7, abs=0.05)
    assert float(run.disturbance_max_2) < 1e-6


def test_perturbed_parameters_make_a_disturbance_of_about_1e4() -> None:
    """Over one second of the sine demand, which holds its peak."""
    simulation = Simulation(1.0, 1e-4, 2, 1e-3)
    loop = replace(example(Loop, simulation=simulation, controller=Nominal()), UPWARD)
    run = simulate(loop, record=["plant.velocity", "plant.hydraulic_force", "controller.u", "disturbance.d2"])
    x1, x2, u = (run[name].values for name in ("plant.velocity", "plant.hydraulic_force", "controller.u"))
    area = DISCHARGE * GRADIENT * VALVE_GAIN * u
    root = np.sqrt((SUPPLY - np.sign(u) * x2 / AREA) / DENSITY)
    nominal_flow = area * root - AREA * x1 - LEAKAGE * x2 / AREA
    true_flow = 1.1 * 1.1 / math.sqrt(1.15) * area * root - AREA * x1 - 1.3 * LEAKAGE * x2 / AREA
    expected = 4.0 * BULK * AREA / VOLUME * (1.1 * true_flow - nominal_flow)
    assert run["disturbance.d2"].values == pytest.approx(expected, rel=1e-9, abs=1e-4)
    assert 1e4 / 2 < float(run.disturbance_max_2) < 2e4
