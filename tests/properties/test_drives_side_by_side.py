"""Loops with drives: side by side, by the energy that they draw, and by how fast they move."""

import math
from typing import Any

import numpy as np
import pytest

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.metrics import declared_metrics, monitors_of
from hydroservo.control.monitors import Energy, PistonTravel
from hydroservo.control.monitors.group import by_class
from hydroservo.core.group import group
from hydroservo.machine.drives import Counterbalance, Hoses, LoadSensing, PressureCompensator, PumpDrive
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.supplies import IdealSupply
from hydroservo.machine.valves import NoValve
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.step_sizes import fastest_rate
from hydroservo.testing.examples import example
from tests.support.tiers import mostly

WATCHED = group(by_class([Energy(), PistonTravel()]))
PUMPED = example(
    Loop,
    Simulation(0.02, 1e-4, 4, 1e-4),
    plant=example(Cylinder),
    valve=NoValve(),
    supply=IdealSupply(40e5),
    drive=example(PumpDrive),
    metrics=WATCHED,
)
NESTED = PUMPED._replace(
    valve=example(Loop).valve,
    drive=LoadSensing(
        10e5, 0.02, PressureCompensator(7e5, example(Counterbalance, volume=1e-4, drive=example(Hoses)))
    ),
)
LOOPS: dict[str, tuple[Loop, dict[str, tuple[float, float]]]] = {
    "pump": (
        PUMPED,
        {
            "drive.displacement": (1e-7, 1e-6),
            "drive.check_valve.pilot_ratio": (0.0, 4.0),
            "drive.leakage": (0.0, 1e-12),
            "plant.start_position": (0.01, 0.07),
        },
    ),
    "all others": (
        NESTED,
        {
            "drive.margin": (5e5, 20e5),
            "drive.drive.drive.pilot_ratio": (0.0, 8.0),
            "drive.drive.drive.drive.volume_a": (1e-5, 1e-4),
            "load.amplitude": (-500.0, 500.0),
            "supply.supply_pressure": (30e5, 60e5),
            "supply.return_pressure": (0.0, 4e5),
        },
    ),
}


@pytest.mark.slow  # each compiles two kernels of a whole machine
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LOOPS, [*LOOPS][:1]))
def test_each_run_has_the_bits_of_its_single_run(name: str) -> None:
    """What starts open, in hoses and at a load-sensing pump, is found for each run."""
    loop, ranges = LOOPS[name]
    rng = np.random.default_rng(7)
    parameters: dict[str, Any] = {path: rng.uniform(*limits, 5) for path, limits in ranges.items()}
    table = simulate_batch(loop, parameters, strict=True)
    for run in range(5):
        own = replace(loop, {path: float(values[run]) for path, values in parameters.items()})
        single = simulate(own, record=[], strict=True)
        assert not single.diverged
        for metric in declared_metrics(monitors_of(loop)):
            a, b = float(table[metric][run]), float(single[metric])
            assert a == b or (math.isnan(a) and math.isnan(b)), (run, metric)


def test_the_energy_drawn_is_that_of_the_shaft_and_of_the_replenishing_line() -> None:
    loop = runnable_loop(PUMPED._replace(simulation=Simulation(0.02, 2e-5, 1, 2e-5)))
    data = simulate(loop)
    drive, line = loop.drive, loop.supply.pressures(loop.supply.init())
    speed, u = data["drive.speed"].values[:-1], data["controller.u"].values[:-1]
    a, b = (data[f"plant.pressure_{side}"].values[:-1] for side in "ab")
    torque = np.clip(drive.speed_gain * (drive.command_gain * u - speed), -drive.max_torque, drive.max_torque)
    fed = [
        drive.replenished(line.supply, pa, pb) + drive.replenished(line.supply, pb, pa)
        for pa, pb in zip(a.tolist(), b.tolist(), strict=True)
    ]
    drawn = 2e-5 * np.sum(torque * speed + line.supply * np.array(fed))
    assert data.supply_energy == pytest.approx(drawn, rel=1e-9)


def test_the_fastest_motion_is_found_in_a_hose_too() -> None:
    """A short hose of little resistance: beta_e/V (1/R) of both its ends, and the valve's."""
    quick = runnable_loop(NESTED._replace(drive=example(Hoses, volume_a=1e-7, resistance_a=1e9)))
    slow = runnable_loop(NESTED._replace(drive=Hoses(1e-4, 1e-4, 1e11, 1e11, example(Hoses).oil)))
    assert fastest_rate(quick) == pytest.approx(
        example(Hoses).oil.effective_bulk_modulus / (1e-7 * 1e9), rel=0.05
    )
    assert fastest_rate(slow) < 0.01 * fastest_rate(quick)
