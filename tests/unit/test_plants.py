"""The cylinder against its equations and an energy balance; the nominal model against the cylinder."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.machine.drives import open_ports
from hydroservo.machine.plants import DesignModel, LoadPressurePlant, LoadPressureState
from hydroservo.machine.supplies import IdealSupply
from hydroservo.machine.valves import FourEdges, StaticValve, StaticValveState
from hydroservo.testing.examples import example

velocities = st.floats(-1.0, 1.0)
forces = st.floats(-1500.0, 1500.0)
flows = st.floats(-1e-3, 1e-3)


def test_rates_are_equations_3_to_5() -> None:
    plant = example(LoadPressurePlant, 2.0, 10.0, 1e-3, 1e-4, 1e9, 1e-11)
    rate = plant.deriv(LoadPressureState(0.1, 50.0, 0.02), PortFlows(2e-4, 2e-4, 2e-4, 2e-4), 30.0)
    assert rate.velocity == pytest.approx((50.0 - 10.0 * 0.1 - 30.0) / 2.0)
    assert rate.hydraulic_force == pytest.approx(4e9 / 1e-4 * (1e-3 * 2e-4 - 1e-6 * 0.1 - 1e-11 * 50.0))
    assert rate.position == 0.1


@given(v=velocities, x2=forces, flow=flows, load=forces)
def test_energy(v: float, x2: float, flow: float, load: float) -> None:
    """Stored power is hydraulic power in, less what friction, leakage and the load take.

    Kinetic m v^2/2 and, in the oil, V_t p_L^2/(8 beta_e).
    """
    plant = example(LoadPressurePlant)
    rate = plant.deriv(LoadPressureState(v, x2, 0.0), PortFlows(flow, flow, flow, flow), load)
    pressure = x2 / plant.piston_area
    pressure_rate = rate.hydraulic_force / plant.piston_area
    stored = plant.mass * v * rate.velocity
    stored += plant.total_volume / (4.0 * plant.bulk_modulus) * pressure * pressure_rate
    taken = [pressure * flow, -plant.damping * v * v, -plant.leakage * pressure**2, -load * v]
    assert stored == pytest.approx(sum(taken), abs=1e-11 * (1.0 + sum(map(abs, taken)) + abs(x2 * v)))


def test_it_starts_at_rest_in_the_middle() -> None:
    plant = example(LoadPressurePlant)
    assert plant.init() == (0.0, 0.0, 0.5 * plant.stroke)


def test_load_pressure() -> None:
    assert example(LoadPressurePlant).load_pressure(LoadPressureState(0.0, 491.0, 0.0)) == pytest.approx(1e6)


@given(v=velocities, x2=forces, u=st.floats(-10.0, 10.0), return_pressure=st.floats(0.0, 5e5))
def test_the_nominal_model_is_the_machine_without_load(
    v: float, x2: float, u: float, return_pressure: float
) -> None:
    """f + g u of eqs. (6)-(7) against the cylinder with the static valve."""
    supply, plant, valve = (
        IdealSupply(40e5, return_pressure),
        example(LoadPressurePlant),
        example(StaticValve),
    )
    model = DesignModel(plant, valve.orifice, supply, valve.gain)
    state = LoadPressureState(v, x2, 0.0)
    opening, line = valve.opening(StaticValveState(), u), supply.pressures(supply.init())
    rate = plant.deriv(state, plant.flows(state, open_ports(valve.orifice, opening, line)), 0.0)
    assert model.f1(v) + model.g1() * x2 == pytest.approx(rate.velocity, abs=1e-9)
    assert model.f2(v, x2) + model.g2(x2, u) * u == pytest.approx(rate.hydraulic_force, rel=1e-12, abs=1e-6)


def test_the_input_gain_has_a_floor() -> None:
    """Where the load pressure eats the supply up, g2 stays above zero."""
    model = example(DesignModel)
    stalled = 40e5 * model.plant.piston_area
    floor = model.plant.flow_gain() * model.valve_gain * model.orifice.flow_per_opening(model.least_drop)
    for force in (stalled, 2.0 * stalled):
        assert model.g2(force, 1.0) == pytest.approx(floor, rel=1e-15)
    assert model.g2(2.0 * stalled, -1.0) > floor > 0.0


def test_the_input_gain_of_no_command_ignores_the_load() -> None:
    assert example(DesignModel).g2(500.0, 0.0) == example(DesignModel).g2(0.0, 1.0)


@pytest.mark.parametrize("hydraulic_force", [0.0, 300.0, 2500.0])
def test_the_supply_gives_what_the_edges_let_through(hydraulic_force: float) -> None:
    """Null leakage is drawn though no load flow is, and what flows back from the load is given back."""
    plant, edges, line = example(LoadPressurePlant), example(FourEdges, clearance=1e-5), Pressures(40e5, 2e5)
    state = LoadPressureState(0.0, hydraulic_force, 0.04)
    mean, half = 21e5, 0.5 * plant.load_pressure(state)
    for opening in (0.0, 1e-4, -1e-4):
        flows = plant.flows(state, open_ports(edges, opening, line))
        ports = edges.port_flows(opening, line, mean + half, mean - half)
        assert flows.a == pytest.approx(ports.a, rel=1e-9)
        assert (flows.supply, flows.tank) == (ports.supply, ports.tank)
    assert plant.flows(state, open_ports(edges, 0.0, line)).supply != 0.0
