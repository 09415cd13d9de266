"""What sensors pass on."""

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, Simulation, ops, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.core.signals import Draws, MachineOutputs
from hydroservo.machine.sensors import IdealSensors, IdealSensorsState, NoisySensors, NoisySensorsState
from hydroservo.testing.examples import example

MACHINE = MachineOutputs(0.1, 20.0, 0.03, 2e6, 1e6, 0.0)
DRAWS = Draws(3.0, 0.0, 17.0)
LOOP = example(Loop, Simulation(0.2, 1e-4, record_period=1e-4, seed=5), sensors=example(NoisySensors))


def noise(result: xr.Dataset, name: str) -> np.ndarray:
    """What the sensors added, in the unit of their signal."""
    difference: np.ndarray = (result[f"sensors.{name}"] - result[f"plant.{name}"]).values
    return difference


def test_ideal_sensors_see_the_state_and_the_command_as_they_are() -> None:
    s = IdealSensors().step(IdealSensorsState(), MACHINE, DRAWS, 1e-5)
    assert IdealSensors().measure(s, MACHINE, 4.0) == (0.1, 20.0, 0.03, 4.0, 2e6, 1e6, 0.0)


def test_noise_is_added_to_velocity_and_hydraulic_force_alone() -> None:
    sensors = NoisySensors(1e-3, 2.0)
    y = sensors.measure(sensors.step(sensors.init(), MACHINE, DRAWS, 1e-5), MACHINE, 4.0)
    assert y.velocity == 0.1 + 1e-3 * ops.normal(3.0, 0.0, 17.0)
    assert y.hydraulic_force == 20.0 + 2.0 * ops.normal(3.0, 1.0, 17.0)
    assert (y.position, y.command, y.pressure_a, y.pressure_b) == (0.03, 4.0, 2e6, 1e6)


def test_noise_does_not_depend_on_what_was_before() -> None:
    sensors = example(NoisySensors)
    fresh = sensors.step(sensors.init(), MACHINE, DRAWS, 1e-5)
    assert sensors.step(NoisySensorsState(7.0, -7.0), MACHINE, DRAWS, 1e-5) == fresh


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return simulate(LOOP)


@pytest.mark.parametrize(("name", "rms"), [("velocity", 5e-4), ("hydraulic_force", 5.0)])
def test_noise_in_a_loop_is_white_and_has_its_declared_rms(result: xr.Dataset, name: str, rms: float) -> None:
    found = noise(result, name) / rms
    count = found.size
    assert abs(found.mean()) < 3.5 / count**0.5
    assert abs((found**2).mean() - 1.0) < 3.5 * (2.0 / count) ** 0.5
    for lag in (1, 2, 10):
        assert abs((found[lag:] * found[:-lag]).mean()) < 3.5 / (count - lag) ** 0.5


def test_the_noises_of_one_run_are_independent(result: xr.Dataset) -> None:
    product = noise(result, "velocity") * noise(result, "hydraulic_force") / (5e-4 * 5.0)
    assert abs(product.mean()) < 3.5 / product.size**0.5


def test_a_sample_draws_the_numbers_of_its_index(result: xr.Dataset) -> None:
    velocity = result["plant.velocity"].values[1234]
    measured = velocity + 5e-4 * ops.normal(5.0, 0.0, 1234.0)
    assert result["sensors.velocity"].values[1234] == pytest.approx(measured, rel=1e-12)


def test_the_same_seed_gives_the_same_run_and_another_seed_another(result: xr.Dataset) -> None:
    assert simulate(LOOP).identical(result)
    other = simulate(replace(LOOP, {"simulation.seed": 6}))
    assert abs(np.corrcoef(noise(other, "velocity"), noise(result, "velocity"))[0, 1]) < 0.1


def test_without_noise_a_run_is_that_of_ideal_sensors() -> None:
    silent = simulate(LOOP._replace(sensors=NoisySensors(0.0, 0.0)), strict=True)
    ideal = simulate(LOOP._replace(sensors=IdealSensors()), strict=True)
    assert all(silent[name].equals(ideal[name]) for name in ideal.data_vars)


def test_the_controller_sees_what_the_sensors_measure() -> None:
    loop = LOOP._replace(controller=PI(2.0, 0.0))
    seen = simulate(loop, record=("sensors.velocity", "reference.value", "controller.u"))
    expected = 2.0 * (seen["reference.value"] - seen["sensors.velocity"])
    assert np.allclose(seen["controller.u"], expected, rtol=0.0, atol=1e-15)
