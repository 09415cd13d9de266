"""Metrics of runs, against their trajectories."""

import math
import warnings
from typing import Any, NamedTuple

import numpy as np
import pytest

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.holds import DelayedHold
from hydroservo.control.metrics import judged_by
from hydroservo.control.monitors import (
    CommandEnergy,
    Energy,
    IntegralCriteria,
    RiseTime,
    StepResponse,
    SupplyLine,
    TrackingError,
)
from hydroservo.control.references import Ramp, Square, Step
from hydroservo.core.block import Block
from hydroservo.core.group import group
from hydroservo.machine.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.machine.loads import Constant, Sine
from hydroservo.machine.plants import Cylinder, LoadPressurePlant
from hydroservo.machine.supplies import PumpSupply
from hydroservo.runs.results import metrics_of
from hydroservo.runs.run import runnable_loop
from hydroservo.testing.examples import example
from tests.support.monitors import FULL, SHORT, rms


def test_square_demand_leaves_the_stroke_from_mid_stroke() -> None:
    """30 mm/s for 2 s: 60 mm, with 39 mm to go."""
    square = replace(SHORT, {"simulation.duration": 2.0})
    data = simulate(square, compiled=False)
    assert bool(data["stroke_left"])
    assert not bool(data["diverged"])
    assert float(data["position_max"]) == pytest.approx(0.039 + 0.060, abs=1e-3)
    assert float(data["position_max"]) == pytest.approx(float(data["plant.position"].max()), rel=1e-4)
    low = simulate(square._replace(plant=example(LoadPressurePlant, start_position=0.009)), compiled=False)
    assert not bool(low["stroke_left"])


def test_metrics_of_a_run_are_those_of_its_trajectory() -> None:
    """With one step a sample the trajectory has all that the monitors hear."""
    loop = replace(SHORT._replace(controller=example(TSMC)), {"simulation.substeps": 1})
    data = simulate(loop, compiled=False)
    error = (data["plant.velocity"] - data["reference.value"]).values[:-1]
    late = slice(50, None)
    miss = (data["controller.observer.d2"] - data["disturbance.d2"]).values[late]
    command = data["controller.u"].values
    assert float(data["rms_error"]) == pytest.approx(rms(error), rel=1e-12)
    assert float(data["steady_rms_error"]) == pytest.approx(rms(error[late]), rel=1e-12)
    assert float(data["estimate_rms_error_2"]) == pytest.approx(rms(miss), rel=1e-12)
    assert float(data["disturbance_max_1"]) == np.abs(data["disturbance.d1"].values).max()
    assert float(data["control_total_variation"]) == pytest.approx(np.abs(np.diff(command)).sum(), rel=1e-12)
    assert data["rms_error"].attrs == {
        **{"units": "m/s", "long_name": "rms of the velocity error", "kind": "metric", "better": "smaller"}
    }
    assert data["position_min"].attrs["worst"] == "least"


def test_a_pump_that_collapses_is_seen() -> None:
    """It gives less than the cylinder takes."""
    pump = example(PumpSupply, demanded_speed=60.0)
    loop = SHORT._replace(supply=pump, reference=Square(0.1, 0.2), load=Constant(0.0))
    data = simulate(loop, metrics=[SupplyLine()], compiled=False)
    pressure = data["supply.pressure"].values
    assert float(data["supply_pressure_min"]) == pytest.approx(pressure.min(), rel=0.02)
    assert float(data["supply_pressure_max"]) == pytest.approx(pressure.max(), rel=0.02)
    dip = float(data["supply_pressure_dip"])
    assert dip == pytest.approx(pump.idle_pressure() - float(data["supply_pressure_min"]), rel=1e-9)
    assert dip > 10e5


def test_the_supply_s_dip_can_be_tuned_by() -> None:
    assert {"supply_pressure_dip"} == set(judged_by([SHORT._replace(metrics=group({"line": SupplyLine()}))]))


def test_the_disturbance_of_a_law_that_knows_its_machine_is_the_load() -> None:
    loop = SHORT._replace(controller=example(TSMC), load=Constant(120.0))
    data = simulate(loop, compiled=False)
    mass = runnable_loop(loop).controller.model.plant.mass
    assert data["disturbance.d1"].values == pytest.approx(np.full(101, -120.0 / mass))
    assert float(data["disturbance_rms_1"]) == pytest.approx(120.0 / mass)
    heavier = replace(runnable_loop(loop), {"controller.model.plant.mass": 2.0 * mass})
    assert float(simulate(heavier, compiled=False)["disturbance_max_1"]) > 10.0 * 120.0 / mass


def test_a_run_that_stops_being_finite_is_a_result() -> None:
    wild = SHORT._replace(simulation=Simulation(duration=4.0, period=1e-2, record_period=1e-2))
    with pytest.warns(match="steps"):
        data = simulate(wild, compiled=False)
    assert bool(data["diverged"])
    assert np.isnan(data["plant.velocity"].values[-1])
    assert math.isnan(float(data["steady_rms_error"]))
    assert math.isfinite(float(data["rms_error"]))


def test_energies_of_a_cylinder_balance() -> None:
    """What the supply gives and the valve does not lose moves the piston, squeezes the oil, and leaks."""
    dt = 2.5e-6
    loop = FULL._replace(
        simulation=Simulation(0.02, dt, 1, dt),
        plant=example(Cylinder, internal_leakage=2.5e-12),
        load=Constant(1000.0),
        reference=example(Square, period=1.0),
        controller=PI(2.0, 200.0),
    )
    data = simulate(loop, metrics=[Energy()])
    v, x, a, b = (
        data[f"plant.{name}"].values for name in ("velocity", "position", "pressure_a", "pressure_b")
    )
    plant, oil = runnable_loop(loop).plant, runnable_loop(loop).plant.oil.bulk_modulus(0.0)
    volume_a = plant.dead_volume_a + plant.area_a * x
    volume_b = plant.dead_volume_b + plant.area_b * (plant.stroke - x)
    moved = np.trapezoid((plant.area_a * a - plant.area_b * b) * v, dx=dt)
    squeezed = np.trapezoid(volume_a * a / oil, a) + np.trapezoid(volume_b * b / oil, b)
    leaked = np.trapezoid(plant.internal_leakage * (a - b) ** 2, dx=dt)
    used = float(data["supply_energy"] - data["valve_loss"])
    assert float(data["valve_loss"]) > 0.0
    assert used == pytest.approx(moved + squeezed + leaked, rel=1e-3)
    assert moved > 0.5 * used

    line = loop.supply.pressures(loop.supply.init())
    openings = loop.valve.gain * data["controller.u"].values
    drawn = [
        loop.valve.orifice.port_flows(opening, line, p, q).supply
        for p, q, opening in zip(a[:-1], b[:-1], openings[:-1], strict=True)
    ]
    assert float(data["supply_energy"]) == pytest.approx(line.supply * dt * sum(drawn), rel=1e-9)


def test_the_command_counts_as_it_acts_at_the_valve() -> None:
    """A command that comes half a period late is the one before for the first of two steps."""
    loop = SHORT._replace(hold=DelayedHold(5e-4))
    data = simulate(loop, metrics=[CommandEnergy(0.1)], compiled=False)
    u = data["controller.u"].values
    acting = np.stack([np.r_[0.0, u[:-2]], u[:-1]], axis=1)
    assert float(data["control_energy"]) == pytest.approx(5e-4 * np.sum(acting**2), rel=1e-12)
    assert float(data["saturation_share"]) == pytest.approx(np.mean(np.abs(acting) >= 0.1), rel=1e-12)


class Nothing(NamedTuple):
    """A state of no numbers."""


HEARD: list[tuple[float, float, float, float]] = []


class Listener(NamedTuple):
    """Keeps the instants, velocities and demands that it hears, and how long each step is."""

    def init(self) -> Nothing:
        return Nothing()

    def step(self, m: Nothing, loop: Block, s: Any, t: float, dt: float) -> Nothing:
        HEARD.append((t, s.plant.velocity, s.reference.value, dt))
        return m

    def values(self, m: Nothing) -> Nothing:
        return m


@pytest.mark.parametrize("integrator", [RK4(), Rosenbrock(), Tsit5()])
def test_ripple_between_samples_counts(integrator: Block) -> None:
    """A load that swings once a sample period: at the samples there is little to see of it."""
    loop = example(
        Loop,
        Simulation(duration=0.2, period=1e-2, substeps=64, record_period=1e-2, integrator=integrator),
        plant=example(LoadPressurePlant, damping=5000.0),
        load=Sine(1000.0, 100.0),
        reference=example(Ramp, time=9.0),
        controller=PI(0.001, 0.0),
    )
    HEARD.clear()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Rosenbrock's steps
        data = simulate(loop, metrics=[TrackingError(), Listener()], compiled=False)
    end = next(i for i, row in enumerate(HEARD) if row[3] == 0.0)
    t, v, demand, dt = np.array(HEARD[1 : end + 1]).T  # the first tried whether the monitor fits
    error = v - demand
    assert t == pytest.approx(np.r_[0.0, np.cumsum(dt)[:-1]], abs=1e-12)
    assert t[-1] == pytest.approx(0.2)
    assert t.size > 8 * 20
    assert float(data["rms_error"]) == pytest.approx(math.sqrt(np.sum(error**2 * dt) / 0.2), rel=1e-12)
    assert float(data["max_error"]) == np.abs(error[:-1]).max()
    late = t >= 0.1 - 1e-9
    steady = math.sqrt(np.sum((error**2 * dt)[late]) / 0.1)
    assert float(data["steady_rms_error"]) == pytest.approx(steady, rel=1e-9)
    sampled = (data["plant.velocity"] - data["reference.value"]).values[10:-1]
    assert float(data["steady_max_error"]) > 5.0 * np.abs(sampled).max()
    assert steady > 5.0 * rms(sampled)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("final", [-0.03, 0.03155, 0.06])
def test_a_jump_at_the_very_end_changes_no_error(compiled: bool, final: float) -> None:
    """However large: the command that answers it moves nothing any more."""
    loop = SHORT._replace(reference=Step(0.03, final, SHORT.simulation.duration), controller=PI(1.0, 100.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a demand of which the run sees nothing
        metrics = [TrackingError(), StepResponse(), RiseTime(), IntegralCriteria()]
        jumps = simulate(loop, metrics=metrics, compiled=compiled)
        stays = simulate(loop._replace(reference=Step(0.03, 0.03)), metrics=metrics, compiled=compiled)
    assert float(jumps["reference.value"][-1]) == final
    assert float(stays["settling_time"]) == 0.05
    assert metrics_of(jumps) == pytest.approx(metrics_of(stays), rel=0.0, abs=0.0, nan_ok=True)
