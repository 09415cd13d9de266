"""Every file in examples/ runs, as its own text says."""

import importlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.core.signals import PortFlows
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.synthetic_logs import EXAMPLE, exact_log, recorded, with_units

EXAMPLES = Path(__file__).parents[2] / "examples"
COVERED = {
    "axis.toml",
    "bench_log.csv",
    "compare_in_python.py",
    "dask.yaml",  # by the tests of work on clusters
    "hopsan_position_servo.toml",
    "my.toml",
    "my_controller.py",
    "my_drive.py",
    "my_drive.toml",
    "my_metric.py",
    "my_metric.toml",
    "my_plant.py",
    "my_plant.toml",
    "my_window.py",
    "on_the_rig.toml",
    "pump_axis.toml",
    "recorded.toml",
    "recorded_demand.csv",
    "spring_fmu.py",  # by the tests of FMUs as loads
    "spring_fmu.toml",  # by the documentation's page on FMUs
    "train_velocity.py",  # by the documentation's page on reinforcement learning
}


def command(*arguments: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    line = [sys.executable, "-c", "from hydroservo.cli import main; main()", *arguments]
    return subprocess.run(line, capture_output=True, text=True, cwd=folder, check=False)


def test_nothing_is_left_out() -> None:
    assert {path.name for path in EXAMPLES.iterdir() if path.is_file()} == COVERED


def test_own_controller_in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    controller = importlib.import_module("my_controller").PressureFeedbackPI()
    loop = example(Loop, Simulation(duration=0.05), controller=controller)
    data = simulate(loop, compiled=False)
    last = data.isel(time=-1)
    assert float(last["plant.velocity"]) == pytest.approx(float(last["reference.value"]), rel=0.05)
    assert data["controller.slow_force"].attrs["units"] == "N"


def test_own_window_in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    law = importlib.import_module("my_window").MeanErrorP(2.0)
    loop = example(Loop, Simulation(duration=1e-3, record_period=1e-5), controller=law)
    compiled, plain = simulate(loop, strict=True), simulate(loop, compiled=False)
    assert (compiled["controller.errors.e5"].values == plain["controller.errors.e5"].values).all()
    errors = np.array([plain[f"controller.errors.e{i}"].values for i in range(1, 6)])
    assert (errors[1:, 1:] == errors[:-1, :-1]).all()
    assert plain["controller.u"].values == pytest.approx(2.0 * errors.mean(axis=0), rel=1e-12)


def test_own_controller_from_a_scenario() -> None:
    done = command("run", "my.toml", "--plugin", "my_controller.py", folder=EXAMPLES)
    assert done.returncode == 0, done.stderr
    assert "did not diverge" in done.stdout


def test_own_metric_in_python_and_from_a_scenario(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    tolerance = importlib.import_module("my_metric").Tolerance(tolerance=0.5e-3)
    data = simulate(load_scenario("rig/1khz-pi-square"), record=(), metrics=[tolerance])
    assert data["out_of_tolerance"].attrs["better"] == "smaller"
    done = command("run", "my_metric.toml", "--plugin", "my_metric.py", "--json", folder=EXAMPLES)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)["metrics"]
    assert said["out_of_tolerance"] == float(data["out_of_tolerance"])
    assert said["settling_time"] > 0.0


def test_own_plant_in_python_and_from_a_scenario(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    hoist = importlib.import_module("my_plant").Hoist
    loop = load_scenario(
        EXAMPLES / "my_plant.toml", {"simulation.duration": "1 s"}, [EXAMPLES / "my_plant.py"]
    )
    data = simulate(
        replace(loop, {"plant": hoist(mass=loop.plant.mass, displacement=loop.plant.displacement)})
    )
    first = data.isel(time=0)
    held = loop.plant.area() * float(first["plant.pressure_a"] - first["plant.pressure_b"])
    assert held == pytest.approx(40.0 * 9.80665)  # the load hangs still
    assert float(first["plant.pressure_a"] + first["plant.pressure_b"]) == pytest.approx(120e5)
    short = ("--set", "simulation.duration=1 s")
    done = command("run", "my_plant.toml", "--plugin", "my_plant.py", "--json", *short, folder=EXAMPLES)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["metrics"]["rms_error"] == float(data["rms_error"])


def test_own_plant_conserves_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the oil brings is lifted, sped up, stored in the lines, or lost to friction and leakage."""
    monkeypatch.syspath_prepend(EXAMPLES)
    module = importlib.import_module("my_plant")
    hoist, state = module.Hoist(leakage=1e-12), module.HoistState(0.3, 0.5, 80e5, 30e5)
    rate = hoist.deriv(state, PortFlows(5e-5, 2e-5, 5e-5, 2e-5), 100.0)
    (p_a, p_b), v = (state.pressure_a, state.pressure_b), state.velocity
    stored = hoist.line_volume / hoist.bulk_modulus * (p_a * rate.pressure_a + p_b * rate.pressure_b)
    lifted = (hoist.mass * hoist.gravity + 100.0) * v + hoist.moving_mass() * v * rate.velocity
    lost = hoist.damping * v**2 + hoist.leakage * (p_a - p_b) ** 2
    assert stored + lifted + lost == pytest.approx(p_a * 5e-5 - p_b * 2e-5)


def test_own_drive_in_python_and_from_a_scenario(monkeypatch: pytest.MonkeyPatch) -> None:
    """The throttle damps: the pressure is steadier after the jump; the drive in it begins at rest."""
    monkeypatch.syspath_prepend(EXAMPLES)
    bypass = importlib.import_module("my_drive").Bypass
    short = {"simulation.duration": "0.25 s", "simulation.substeps": 300}
    loop = load_scenario(EXAMPLES / "my_drive.toml", short, [EXAMPLES / "my_drive.py"])
    damped, free = (
        simulate(replace(loop, {"drive": bypass(conductance, drive=loop.drive.drive)}))
        for conductance in (loop.drive.conductance, 0.0)
    )
    assert float(free["drive.pressure_a"][0]) == float(free["plant.pressure_a"][0])
    after = slice(50, None)
    assert float(damped["plant.velocity"][after].std()) < 0.5 * float(free["plant.velocity"][after].std())


def test_an_axis_on_a_pump() -> None:
    data = simulate(load_scenario(EXAMPLES / "pump_axis.toml", {"simulation.substeps": 200}))
    assert not data.stroke_left
    assert float(data.pressure_min) > 7e5  # it is replenished at 8 bar
    assert data.rms_error < 0.03


@pytest.mark.slow  # all that hydroservo check asks
@pytest.mark.parametrize(
    "name", ["my_controller.py", "my_drive.py", "my_metric.py", "my_plant.py", "my_window.py"]
)
def test_own_blocks_hold_to_the_contract(name: str) -> None:
    done = command("check", name, folder=EXAMPLES)
    assert done.returncode == 0, done.stdout


def test_scenario_alone_runs_no_code(tmp_path: Path) -> None:
    shutil.copy(EXAMPLES / "my.toml", tmp_path)
    text = (EXAMPLES / "my_controller.py").read_text(encoding="utf-8")
    trap = 'from pathlib import Path\n\nPath("executed").touch()\n'
    (tmp_path / "my_controller.py").write_text(text + trap, encoding="utf-8")
    done = command("run", "my.toml", folder=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("hydroservo: my.toml: controller.type: 'PressureFeedbackPI'")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "executed").exists()


@pytest.mark.slow  # whole programs
def test_a_law_on_the_rig_and_its_search() -> None:
    done = command("run", "on_the_rig.toml", folder=EXAMPLES)
    assert done.returncode == 0, done.stderr
    assert "did not diverge" in done.stdout
    done = command("tune", "on_the_rig.toml", "--candidates", "64", folder=EXAMPLES)
    assert done.returncode == 0, done.stderr
    assert "192 closed loops were simulated." in done.stdout


def test_recorded_demand_and_load() -> None:
    data = simulate(load_scenario(EXAMPLES / "recorded.toml"))
    assert not data["diverged"]
    assert not data["stroke_left"]
    assert float(data["reference.value"].max()) == pytest.approx(0.025, rel=0.01)  # 25 mm/s in the file
    assert float(data["load.force"].max()) == pytest.approx(120.0)  # 0.12 kN


@pytest.mark.slow  # whole programs
def test_a_position_servo_of_another_simulator() -> None:
    done = command("run", "hopsan_position_servo.toml", "--set", "simulation.duration=0.2 s", folder=EXAMPLES)
    assert done.returncode == 0, done.stderr
    assert "did not diverge" in done.stdout


def test_an_axis_from_datasheets() -> None:
    data = simulate(load_scenario(EXAMPLES / "axis.toml"))
    assert not data["diverged"]
    assert not data["stroke_left"]
    assert float(data["max_error"]) < 0.05 * float(data["reference.value"].max())
    assert "warning" not in data.attrs


@pytest.mark.slow  # whole programs
def test_comparison_in_python() -> None:
    line = [sys.executable, "compare_in_python.py"]
    done = subprocess.run(line, capture_output=True, text=True, cwd=EXAMPLES, check=False)
    assert done.returncode == 0, done.stderr
    header, *rows = done.stdout.splitlines()
    assert header.split() == ["bulk", "modulus", "controller", "rms", "error", "total", "variation"]
    assert len(rows) == 6


def test_the_log_is_one_of_the_machine_with_which_it_is_fitted():
    table = pd.read_csv(EXAMPLES / "bench_log.csv")
    made = with_units(recorded(exact_log(EXAMPLE), 0))
    assert list(table) == list(made)
    for name, values in made.items():
        np.testing.assert_allclose(table[name], values, atol=1e-9 * np.ptp(values))
